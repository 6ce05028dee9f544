/// EyeNavGS (Ding et al., arXiv 2506.02380, 2025): one row per eye, alternating left and right, both with the
/// rotation of the head. The head is midway between the eyes; the eye distance is the median distance of all
/// pairs. The pose of a pair was sampled once and logged in two rows about 6 ms apart, so the stamp of the
/// left row is used. A last left row without a right row is ignored, and a bad row is left out with its pair.
/// The sign tells which vertical fov angle is up and which is down.
#include <algorithm>
#include <array>
#include <utility>

#include "stereo/base/quantile.h"
#include "stereo/head/formats.h"
#include "stereo/head/samples.h"

namespace farshade::formats {
namespace {

constexpr std::size_t kColumns = 20, kStampColumn = 19;

struct EyeRow {
  rows::Place place;
  std::size_t view = 0;  ///< 0 left, 1 right
  EyeFov fov;
  glm::dvec3 position{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
  std::string_view stamp;
  double stamp_ms = 0;
};

Expected<EyeRow> read_row(const std::vector<std::string_view>& fields, rows::Place place) {
  if (fields.size() != kColumns)
    return rows::fail_at(place, Fault::Malformed,
                         "row has " + std::to_string(fields.size()) + " of 20 columns");
  std::array<double, 12> v{};  // the columns before the gaze
  for (std::size_t i = 0; i < v.size(); ++i) {
    const Expected<double> value = rows::number(fields[i], place);
    if (!value) return tl::unexpected(value.error());
    v[i] = *value;
  }
  const Expected<double> stamp = rows::number(fields[kStampColumn], place);
  if (!stamp) return tl::unexpected(stamp.error());
  if (v[0] != 0.0 && v[0] != 1.0)
    return rows::fail_at(place, Fault::Malformed, "ViewIndex is neither 0 nor 1");
  const auto [down, up] = std::minmax(v[3], v[4]);
  if (!(v[1] < 0 && v[2] > 0 && down < 0 && up > 0))
    return rows::fail_at(place, Fault::OutOfRange,
                         "fov angles should be left < 0 < right and one up, one down");
  return EyeRow{.place = place,
                .view = v[0] == 0.0 ? 0u : 1u,
                .fov = {.left_rad = v[1], .right_rad = v[2], .up_rad = up, .down_rad = down},
                .position = {v[5], v[6], v[7]},
                .rotation = glm::dquat(v[11], v[8], v[9], v[10]),
                .stamp = fields[kStampColumn],
                .stamp_ms = *stamp};
}

/// The recording while it is read, pair by pair.
struct Pairs {
  SampleList samples;
  std::vector<double> distances, rightward;  ///< world units; rightward is along +x of the head
  PerEye<EyeFov> fov;
  std::optional<EyeRow> left;  ///< the row that waits for its right row
  bool lacks_left = false;     ///< the last left row was bad, and its pair is counted
};

/// A row without a view is the one that is due.
bool is_right(const Expected<EyeRow>& row, std::string_view view, const Pairs& pairs) {
  if (row) return row->view == 1;
  return view == "1" || (view != "0" && (pairs.left || pairs.lacks_left));
}

Expected<void> add_pair(const EyeRow& left, const EyeRow& right, Pairs& pairs) {
  if (left.rotation != right.rotation)
    return rows::fail_at(right.place, Fault::Malformed, "the pair's rows do not share one quaternion");
  if (right.stamp_ms < left.stamp_ms)
    return rows::fail_at(right.place, Fault::Malformed, "time stamp lies before that of the pair's left row");
  const PerEye<EyeFov> fov{left.fov, right.fov};
  if (pairs.distances.empty()) pairs.fov = fov;
  if (fov != pairs.fov)
    return rows::fail_at(right.place, Fault::Unsupported, "fov changes within the recording");
  const glm::dvec3 across = right.position - left.position;
  pairs.distances.push_back(glm::length(across));
  pairs.rightward.push_back(glm::dot(across, left.rotation * glm::dvec3(1, 0, 0)));
  return pairs.samples.add(left.place, left.stamp, 0.5 * (left.position + right.position), left.rotation);
}

tl::unexpected<Error> out_of_turn(rows::Place place) {
  return rows::fail_at(place, Fault::Malformed, "left and right rows should alternate");
}

void take_left(const Expected<EyeRow>& row, rows::Place place, Pairs& pairs) {
  if (pairs.left) pairs.samples.leave_out(out_of_turn(place).value());
  pairs.left = row ? std::optional(*row) : std::nullopt;
  pairs.lacks_left = !row;
  if (!row) pairs.samples.leave_out(row.error());
}

void take_right(const Expected<EyeRow>& row, rows::Place place, Pairs& pairs) {
  const std::optional<EyeRow> left = std::exchange(pairs.left, std::nullopt);
  if (std::exchange(pairs.lacks_left, false)) return;
  Expected<void> added = out_of_turn(place);
  if (left) added = row ? add_pair(*left, *row, pairs) : tl::unexpected(row.error());
  if (!added) pairs.samples.leave_out(added.error());
}

}  // namespace

Expected<HeadRecording> read_eyenavgs(std::string_view text, std::string_view name, double units_a_metre,
                                      const HeadFileOptions& options) {
  Pairs pairs;
  rows::Lines lines(text, name);
  std::vector<std::string_view> fields;
  for (std::string_view line; lines.next(line);) {
    if (is_comment(line) || line.starts_with("ViewIndex,")) continue;
    rows::split(line, ',', fields);
    const Expected<EyeRow> row = read_row(fields, lines.place());
    if (is_right(row, fields.front(), pairs))
      take_right(row, lines.place(), pairs);
    else
      take_left(row, lines.place(), pairs);
  }
  if (quantile(pairs.rightward, 0.5) < 0)
    return fail(Fault::Malformed, std::string(name) + ": the right eye lies left of the left eye");
  return std::move(pairs.samples)
      .finish({.file = name,
               .format = "EyeNavGS",
               .units_a_metre = units_a_metre,
               .usual_unit = TimeUnit::Milliseconds,
               .unit = TimeUnit::Milliseconds,
               .order_read = QuaternionOrder::Xyzw,
               .states_order = true,
               .eye_distance_m = quantile(pairs.distances, 0.5) / units_a_metre,
               .fov = pairs.fov},
              options);
}

}  // namespace farshade::formats
