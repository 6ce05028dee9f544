#include "stereo/plan/light_reach.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace farshade {
namespace {

/// Relative margin of distances, and angle in radians. It exceeds the rounding of float in shaders and rays.
constexpr double kSlack = 1e-5;

double distance_to(const Bounds& box, const glm::dvec3& p) {
  return glm::length(p - glm::clamp(p, box.low, box.high));
}

/// The angle at `p` between `direction` and the nearest point of the box's bounding sphere; 0 if `p` is
/// inside it.
double angle_to_ball(const Bounds& box, const glm::dvec3& p, const glm::dvec3& direction) {
  const glm::dvec3 to_centre = (box.low + box.high) * 0.5 - p;
  const double radius = glm::length(box.high - box.low) * 0.5, distance = glm::length(to_centre);
  if (!(distance > radius)) return 0;
  const double across = glm::length(glm::cross(to_centre, direction)), along = glm::dot(to_centre, direction);
  return std::max(std::atan2(across, along) - std::asin(radius / distance), 0.0);
}

}  // namespace

bool may_reach(const Light& light, const Bounds& box) {
  if (light.kind == LightKind::Directional) return true;
  const double distance = distance_to(box, light.position.v);
  if (light.range_m > 0 && distance > light.range_m * (1 + kSlack)) return false;
  if (light.kind != LightKind::Spot) return true;
  return angle_to_ball(box, light.position.v, light.direction.v) <= light.outer_cone_rad + kSlack;
}

}  // namespace farshade
