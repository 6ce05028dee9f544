/// Rigid motions as screws: a constant body twist carries a head along an exact arc (a turn about the neck is
/// one), and every motion between two poses is the screw of one twist.
/// Source: J. Sola, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation in robotics", 2018,
/// appendix D (SE(3)); closed forms, with series near zero.
#pragma once

#include "stereo/math/rotation.h"

namespace farshade {

/// How a frame moves, in its own axes: a body twist. Times a number of seconds it is a motion (rad, m).
struct Twist {
  glm::dvec3 angular{0.0};  ///< rad/s
  glm::dvec3 linear{0.0};   ///< m/s
  friend bool operator==(const Twist&, const Twist&) = default;
};

inline Twist operator+(const Twist& a, const Twist& b) {
  return {a.angular + b.angular, a.linear + b.linear};
}
inline Twist operator-(const Twist& a, const Twist& b) {
  return {a.angular - b.angular, a.linear - b.linear};
}
inline Twist operator*(const Twist& a, double s) {
  return {a.angular * s, a.linear * s};
}

/// Where the origin comes to when its frame makes the motion: V(angular) * linear, the mean of the rotations
/// passed through times the path.
[[nodiscard]] glm::dvec3 screw_translation(const Twist& motion);

/// Inverse of screw_translation: the `linear` that with `angular` (length up to pi) leads to `translation`.
[[nodiscard]] glm::dvec3 screw_linear(const glm::dvec3& angular, const glm::dvec3& translation);

/// Exponential of a motion (rad, m).
template <class Space>
[[nodiscard]] Rigid<Space, Space> motion_exp(const Twist& motion) {
  return {rotation_exp(motion.angular), screw_translation(motion)};
}

/// Logarithm: the motion (rad, m) that motion_exp makes of, turning the shorter way round.
template <class Space>
[[nodiscard]] Twist motion_log(const Rigid<Space, Space>& moved) {
  const glm::dvec3 angular = rotation_log(moved.rotation);
  return {angular, screw_linear(angular, moved.translation)};
}

/// The motion (rad, m; in From's axes) that leads from pose `a` to pose `b`: b = a * motion_exp(motion).
template <class To, class From>
[[nodiscard]] Twist motion_between(const Rigid<To, From>& a, const Rigid<To, From>& b) {
  const glm::dquat back = glm::conjugate(a.rotation);
  // Positions are subtracted before they are turned, so that nothing is lost far from the origin.
  return motion_log(Rigid<From, From>{back * b.rotation, back * (b.translation - a.translation)});
}

}  // namespace farshade
