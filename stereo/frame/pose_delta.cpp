#include "stereo/frame/pose_delta.h"

#include <glm/geometric.hpp>

#include "stereo/math/rotation.h"

namespace farshade {

PoseDelta pose_delta(const View& shown, Time shown_at, const View& traced, Time traced_for) {
  const auto &to = traced.stage_from_eye, &from = shown.stage_from_eye;
  PoseDelta delta{.traced_from_shown = {}, .angle_rad = 0, .distance_m = 0, .age = shown_at - traced_for};
  if (to == from) return delta;
  const glm::dquat back = glm::conjugate(to.rotation);
  // Subtracting before rotating keeps the precision 1,000 km from the origin.
  delta.traced_from_shown = {
      to.rotation == from.rotation ? glm::dquat(1, 0, 0, 0) : glm::normalize(back * from.rotation),
      back * (from.translation - to.translation)};
  delta.angle_rad = to.rotation == from.rotation ? 0 : angle_between_rad(to.rotation, from.rotation);
  delta.distance_m = glm::length(from.translation - to.translation);
  return delta;
}

}  // namespace farshade
