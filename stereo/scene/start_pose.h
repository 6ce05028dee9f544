/// StartPose: where a user places the head, instead of at the scene's viewpoint.
#pragma once

#include <optional>
#include <string_view>

#include "stereo/scene/viewpoint.h"

namespace farshade {

struct StartPose {
  Point<Stage> at;
  std::optional<double> heading_rad;  ///< about +y, from -z to the left; none: as at the viewpoint
  friend bool operator==(const StartPose&, const StartPose&) = default;
};

/// Parses the value of --stand: X,Y,Z in metres and perhaps a heading in degrees. Malformed or OutOfRange
/// otherwise.
[[nodiscard]] Expected<StartPose> parse_start_pose(std::string_view text);

/// The scene's viewpoint (viewpoint.h), or level at `start_pose`.
[[nodiscard]] Rigid<Stage, Eye> viewpoint_of(const Scene& scene, const std::optional<StartPose>& start_pose);

}  // namespace farshade
