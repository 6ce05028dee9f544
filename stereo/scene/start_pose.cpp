#include "stereo/scene/start_pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stereo/math/rotation.h"
#include "stereo/scene/option_words.h"

namespace farshade {
namespace {

constexpr double kFarthest_m = 1e9;

}  // namespace

Expected<StartPose> parse_start_pose(std::string_view text) {
  std::vector<double> values;
  const std::vector<std::string_view> parts = split(text, ',');
  for (const std::string_view part : parts)
    if (const std::optional<double> value = number_in(part)) values.push_back(*value);
  if (values.size() != parts.size() || values.size() < 3 || values.size() > 4)
    return fail(Fault::Malformed,
                fmt::format("--stand {}: write X,Y,Z in metres and perhaps a heading in degrees, for example "
                            "-3.4,1.4,-4,180; heading 0 is -z and 90 is -x",
                            text));
  if (std::ranges::any_of(values, [](double value) { return std::abs(value) > kFarthest_m; }))
    return fail(Fault::OutOfRange, fmt::format("--stand {}: its numbers are at most 1e9", text));
  StartPose start_pose{.at = {{values[0], values[1], values[2]}}, .heading_rad = std::nullopt};
  if (values.size() == 4) start_pose.heading_rad = std::remainder(values[3], 360) * std::numbers::pi / 180;
  return start_pose;
}

Rigid<Stage, Eye> viewpoint_of(const Scene& scene, const std::optional<StartPose>& start_pose) {
  if (!start_pose) return viewpoint_of(scene);
  const double heading_rad = start_pose->heading_rad ? *start_pose->heading_rad
                                                     : farshade::heading_rad(viewpoint_of(scene).rotation);
  return {.rotation = rotation_exp({0, heading_rad, 0}), .translation = start_pose->at.v};
}

}  // namespace farshade
