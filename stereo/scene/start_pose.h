/// StartPose: where a user places the head, instead of at the scene's viewpoint.
#pragma once

#include <optional>

#include "stereo/scene/viewpoint.h"

namespace farshade {

struct StartPose {
  Point<Stage> at;
  std::optional<double> heading_rad;  ///< about +y, from -z to the left; none: as at the viewpoint
  friend bool operator==(const StartPose&, const StartPose&) = default;
};

/// The scene's viewpoint (viewpoint.h), or level at `start_pose`.
[[nodiscard]] Rigid<Stage, Eye> viewpoint_of(const Scene& scene, const std::optional<StartPose>& start_pose);

}  // namespace farshade
