#include "stereo/math/rotation.h"

#include <cmath>

namespace farshade {

glm::dquat rotation_exp(const glm::dvec3& rotation_vector) {
  const double angle2 = glm::dot(rotation_vector, rotation_vector);
  const double angle = std::sqrt(angle2);
  // sin(a/2)/a by its series below 1e-4 rad, where the next term is under 1e-18.
  const double sinc_half = angle < 1e-4 ? 0.5 - angle2 / 48.0 : std::sin(0.5 * angle) / angle;
  const glm::dvec3 xyz = rotation_vector * sinc_half;
  return glm::normalize(glm::dquat(std::cos(0.5 * angle), xyz.x, xyz.y, xyz.z));
}

glm::dvec3 rotation_log(const glm::dquat& rotation) {
  const double sign = rotation.w < 0 ? -1.0 : 1.0;
  const glm::dvec3 xyz = sign * glm::dvec3(rotation.x, rotation.y, rotation.z);
  const double w = sign * rotation.w;
  const double sine = glm::length(xyz);
  const double angle_by_sine = sine < 1e-8 ? 2.0 / w : 2.0 * std::atan2(sine, w) / sine;
  return xyz * angle_by_sine;
}

double angle_between_rad(const glm::dquat& a, const glm::dquat& b) {
  return glm::length(rotation_log(glm::conjugate(a) * b));
}

glm::dquat slerp(const glm::dquat& a, const glm::dquat& b, double t) {
  return glm::normalize(a * rotation_exp(t * rotation_log(glm::conjugate(a) * b)));
}

double heading_rad(const glm::dquat& rotation) {
  const glm::dvec3 ahead = rotation * glm::dvec3(0, 0, -1);
  const glm::dvec3 up = rotation * glm::dvec3(0, 1, 0);
  // If the head looks straight up or down, the direction of its bottom (or top) defines the heading.
  const double level2 = ahead.x * ahead.x + ahead.z * ahead.z;
  const glm::dvec3 level = level2 > 1e-12 ? ahead : (ahead.y > 0 ? -up : up);
  return std::atan2(-level.x, -level.z);
}

}  // namespace farshade
