/// Rotations by exponential and logarithm map, with series near zero. Angles use atan2, never acos.
/// Source: J. Sola, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation in robotics", 2018,
/// section IV.
#pragma once

#include "stereo/math/spaces.h"

namespace farshade {

/// Unit quaternion of a rotation vector (axis times angle in radians).
[[nodiscard]] glm::dquat rotation_exp(const glm::dvec3& rotation_vector);

/// Rotation vector of a unit quaternion: the shorter rotation, length in [0, pi].
[[nodiscard]] glm::dvec3 rotation_log(const glm::dquat& rotation);

/// Angle between two unit quaternions, radians, in [0, pi].
[[nodiscard]] double angle_between_rad(const glm::dquat& a, const glm::dquat& b);

/// Constant-speed rotation from `a` (t = 0) to `b` (t = 1) in the shorter direction. Other t extrapolate.
[[nodiscard]] glm::dquat slerp(const glm::dquat& a, const glm::dquat& b, double t);

/// Angle about +y (radians, counter-clockwise seen from above) from -z to the rotated -z axis.
[[nodiscard]] double heading_rad(const glm::dquat& rotation);

/// Interpolates the position linearly and the rotation by slerp.
template <class To, class From>
[[nodiscard]] Rigid<To, From> interpolate(const Rigid<To, From>& a, const Rigid<To, From>& b, double t) {
  return {slerp(a.rotation, b.rotation, t), a.translation + (b.translation - a.translation) * t};
}

}  // namespace farshade
