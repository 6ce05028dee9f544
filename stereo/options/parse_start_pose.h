/// The value of --stand.
#pragma once

#include <string_view>

#include "stereo/scene/start_pose.h"

namespace farshade {

/// Parses the value of --stand: X,Y,Z in metres and perhaps a heading in degrees. Malformed or OutOfRange
/// otherwise.
[[nodiscard]] Expected<StartPose> parse_start_pose(std::string_view text);

}  // namespace farshade
