/// Tables: one pose per row, in columns that layout.h finds.
#include <array>

#include "stereo/head/formats.h"
#include "stereo/head/samples.h"

namespace farshade::formats {
namespace {

Expected<EyeFov> read_fov(std::string_view value, rows::Place place) {
  std::vector<std::string_view> fields;
  rows::split(value, ' ', fields);
  if (fields.size() != 4) return rows::fail_at(place, Fault::Malformed, "fov needs four angles");
  std::array<double, 4> angles{};
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const Expected<double> angle = rows::number(fields[i], place);
    if (!angle) return tl::unexpected(angle.error());
    angles[i] = *angle;
  }
  return EyeFov{.left_rad = angles[0], .right_rad = angles[1], .up_rad = angles[2], .down_rad = angles[3]};
}

/// "m, ns": positions in metres, and a unit of time stamps.
std::optional<TimeUnit> read_units(std::string_view value) {
  for (const TimeUnit unit : kTimeUnits)
    if (value == "m, " + std::string(to_string(unit))) return unit;
  return std::nullopt;
}

/// Reads a line `# key: value`. Unknown keys are comments.
Expected<void> read_comment(std::string_view line, rows::Place place, FileFacts& facts) {
  const std::size_t colon = line.find(':');
  if (colon == line.npos) return {};
  const std::string_view key = rows::trimmed(line.substr(1, colon - 1)),
                         value = rows::trimmed(line.substr(colon + 1));
  if (key == kAxesKey) {
    if (value != kAxes)
      return rows::fail_at(place, Fault::Unsupported, "axes should be " + std::string(kAxes));
    facts.states_axes = true;
  }
  if (key == kUnitsKey) {
    facts.unit = read_units(value);
    if (!facts.unit)
      return rows::fail_at(
          place, Fault::Unsupported,
          "units should be " + std::string(facts.usual_unit == TimeUnit::Seconds ? kTumUnits : kEurocUnits));
  }
  if (key == kEyeDistanceKey) {
    const Expected<double> distance = rows::number(value, place);
    if (!distance) return tl::unexpected(distance.error());
    facts.eye_distance_m = *distance;
  }
  for (const Side side : kSides) {
    if (key != kFovKeys[index_of(side)]) continue;
    const Expected<EyeFov> fov = read_fov(value, place);
    if (!fov) return tl::unexpected(fov.error());
    facts.fov[index_of(side)] = *fov;
  }
  return {};
}

Expected<void> read_row(const std::vector<std::string_view>& fields, const Layout& layout, rows::Place place,
                        SampleList& samples) {
  if (fields.size() < layout.columns || (fields.size() > layout.columns && !layout.is_named))
    return rows::fail_at(
        place, Fault::Malformed,
        "row has " + std::to_string(fields.size()) + " of " + std::to_string(layout.columns) + " columns");
  if (layout.tracked && (fields[*layout.tracked] == "0" || fields[*layout.tracked] == "false" ||
                         fields[*layout.tracked] == "False"))
    return rows::fail_at(place, Fault::Malformed, "tracking was lost");
  std::array<double, 7> v{};  // position, quaternion
  for (std::size_t i = 0; i < v.size(); ++i) {
    const Expected<double> value =
        rows::number(fields[i < 3 ? layout.position + i : layout.rotation + i - 3], place);
    if (!value) return tl::unexpected(value.error());
    v[i] = *value;
  }
  const glm::dquat rotation = layout.order == QuaternionOrder::Wxyz ? glm::dquat(v[3], v[4], v[5], v[6])
                                                                    : glm::dquat(v[6], v[3], v[4], v[5]);
  return samples.add(place, fields[layout.stamp], {v[0], v[1], v[2]}, rotation);
}

}  // namespace

Expected<HeadRecording> read_table(std::string_view text, std::string_view name, double units_a_metre,
                                   const HeadFileOptions& options) {
  const Expected<Layout> layout = layout_of(text, name);
  if (!layout) return tl::unexpected(layout.error());
  const bool states_scale = layout->units_a_metre && !options.units_a_metre;
  FileFacts facts{.file = name,
                  .format = layout->is_named           ? "named columns"
                            : layout->separator == ',' ? "EuRoC columns"
                                                       : "TUM columns",
                  .units_a_metre = states_scale ? *layout->units_a_metre : units_a_metre,
                  .states_scale = states_scale,
                  .usual_unit = layout->usual_unit,
                  .unit = layout->unit,
                  .order_read = layout->order,
                  .states_order = layout->is_named};
  SampleList samples;
  rows::Lines lines(text, name);
  std::vector<std::string_view> fields;
  for (std::string_view line; lines.next(line);) {
    if (is_comment(line)) {
      if (const Expected<void> read = read_comment(line, lines.place(), facts); !read)
        return tl::unexpected(read.error());
    } else if (lines.place().line != layout->header_line) {
      split_row(line, layout->separator, fields);
      if (const Expected<void> read = read_row(fields, *layout, lines.place(), samples); !read)
        samples.leave_out(read.error());
    }
  }
  return std::move(samples).finish(facts, options);
}

}  // namespace farshade::formats
