#include "stereo/options/parse_start_pose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "stereo/options/option_words.h"

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

}  // namespace farshade
