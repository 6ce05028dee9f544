#include "stereo/scene/start_pose.h"

#include "stereo/math/rotation.h"

namespace farshade {

Rigid<Stage, Eye> viewpoint_of(const Scene& scene, const std::optional<StartPose>& start_pose) {
  if (!start_pose) return viewpoint_of(scene);
  const double heading_rad = start_pose->heading_rad ? *start_pose->heading_rad
                                                     : farshade::heading_rad(viewpoint_of(scene).rotation);
  return {.rotation = rotation_exp({0, heading_rad, 0}), .translation = start_pose->at.v};
}

}  // namespace farshade
