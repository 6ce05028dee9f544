/// EuRoC and TUM: one pose per row. They differ in separator, unit of time and column of the quaternion's w.
#include <array>

#include "stereo/head/formats.h"
#include "stereo/head/samples.h"

namespace farshade::formats {
namespace {

struct Layout {
  char separator;
  int stamp_digits;                 ///< stamps are in 10^digits ns
  std::array<std::size_t, 4> wxyz;  ///< columns of the quaternion
  std::string_view units, columns;
};
constexpr std::size_t kColumns = 8;  // stamp, position, quaternion
constexpr Layout kEuroc{',', 0, {4, 5, 6, 7}, kEurocUnits, kEurocColumns};
constexpr Layout kTum{' ', 9, {7, 4, 5, 6}, kTumUnits, kTumColumns};

struct Headset {
  double eye_distance_m = kDefaultEyeDistance_m;
  PerEye<EyeFov> fov = kDefaultFov;
};

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

/// Refuses a file whose column names have another order, because its quaternions would be misread.
Expected<void> check_columns(std::string_view names, const Layout& layout, rows::Place place) {
  std::vector<std::string_view> theirs, ours;
  rows::split(names, layout.separator, theirs);
  rows::split(layout.columns, layout.separator, ours);
  const auto base_of = [](std::string_view name) { return rows::trimmed(name.substr(0, name.find('['))); };
  for (std::size_t i = 1; i < ours.size(); ++i)
    if (i >= theirs.size() || base_of(theirs[i]) != base_of(ours[i]))
      return rows::fail_at(place, Fault::Unsupported, "columns should be " + std::string(layout.columns));
  return {};
}

/// Reads a line `# key: value`. Unknown keys are comments.
Expected<void> read_comment(std::string_view line, const Layout& layout, rows::Place place,
                            Headset& headset) {
  line = rows::trimmed(line.substr(1));
  if (line.starts_with("timestamp") && line.find('q') != line.npos) return check_columns(line, layout, place);
  const std::size_t colon = line.find(':');
  if (colon == line.npos) return {};
  const std::string_view key = rows::trimmed(line.substr(0, colon)),
                         value = rows::trimmed(line.substr(colon + 1));
  if (const std::string_view ours = key == kAxesKey ? kAxes : layout.units;
      (key == kAxesKey || key == kUnitsKey) && value != ours)
    return rows::fail_at(place, Fault::Unsupported, std::string(key) + " should be " + std::string(ours));
  if (key == kEyeDistanceKey) {
    const Expected<double> distance = rows::number(value, place);
    if (!distance) return tl::unexpected(distance.error());
    headset.eye_distance_m = *distance;
  }
  for (const Side side : kSides) {
    if (key != kFovKeys[index_of(side)]) continue;
    const Expected<EyeFov> fov = read_fov(value, place);
    if (!fov) return tl::unexpected(fov.error());
    headset.fov[index_of(side)] = *fov;
  }
  return {};
}

Expected<void> read_row(const std::vector<std::string_view>& fields, const Layout& layout, rows::Place place,
                        SampleList& samples) {
  if (fields.size() < kColumns)
    return rows::fail_at(place, Fault::Malformed,
                         "row has " + std::to_string(fields.size()) + " of 8 columns");
  const Expected<std::int64_t> stamp = rows::nanoseconds(fields[0], layout.stamp_digits, place);
  if (!stamp) return tl::unexpected(stamp.error());
  std::array<double, kColumns> values{};
  for (std::size_t i = 1; i < kColumns; ++i) {
    const Expected<double> value = rows::number(fields[i], place);
    if (!value) return tl::unexpected(value.error());
    values[i] = *value;
  }
  const auto& [w, x, y, z] = layout.wxyz;
  return samples.add(place, *stamp, {values[1], values[2], values[3]},
                     glm::dquat(values[w], values[x], values[y], values[z]));
}

Expected<HeadRecording> read(std::string_view text, std::string_view name, double units_a_metre,
                             const Layout& layout) {
  SampleList samples(units_a_metre);
  Headset headset;
  rows::Lines lines(text, name);
  std::vector<std::string_view> fields;
  for (std::string_view line; lines.next(line);) {
    if (line.front() != '#') rows::split(line, layout.separator, fields);
    const Expected<void> read = line.front() == '#' ? read_comment(line, layout, lines.place(), headset)
                                                    : read_row(fields, layout, lines.place(), samples);
    if (!read) return tl::unexpected(read.error());
  }
  return std::move(samples).finish(name, headset.eye_distance_m, headset.fov);
}

}  // namespace

Expected<HeadRecording> read_euroc(std::string_view text, std::string_view name, double units_a_metre) {
  return read(text, name, units_a_metre, kEuroc);
}

Expected<HeadRecording> read_tum(std::string_view text, std::string_view name, double units_a_metre) {
  return read(text, name, units_a_metre, kTum);
}

}  // namespace farshade::formats
