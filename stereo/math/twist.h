/// Rigid motions as screws: a constant body twist moves a head along an exact arc (for example a turn about
/// the neck). Every motion between two poses is the screw of one twist. Source: J. Sola, J. Deray, D.
/// Atchuthan, "A micro Lie theory for state estimation in robotics", 2018, appendix D (SE(3)); closed forms,
/// with series near zero.
#pragma once

#include "stereo/math/rotation.h"

namespace farshade {

/// A body twist: the velocity of a frame in its own axes. Multiplied by seconds it is a motion (rad, m).
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

/// The translation of the origin by the motion: V(angular) * linear, where V is the mean of the rotations
/// during the motion.
[[nodiscard]] glm::dvec3 screw_translation(const Twist& motion);

/// Inverse of screw_translation: the `linear` that gives `translation` with `angular` (length up to pi).
[[nodiscard]] glm::dvec3 screw_linear(const glm::dvec3& angular, const glm::dvec3& translation);

/// Exponential of a motion (rad, m).
template <class Space>
[[nodiscard]] Rigid<Space, Space> motion_exp(const Twist& motion) {
  return {rotation_exp(motion.angular), screw_translation(motion)};
}

/// Inverse of motion_exp: the motion (rad, m) with the shorter rotation.
template <class Space>
[[nodiscard]] Twist motion_log(const Rigid<Space, Space>& moved) {
  const glm::dvec3 angular = rotation_log(moved.rotation);
  return {angular, screw_linear(angular, moved.translation)};
}

/// The motion (rad, m, in the axes of From) from pose `a` to pose `b`: b = a * motion_exp(motion).
template <class To, class From>
[[nodiscard]] Twist motion_between(const Rigid<To, From>& a, const Rigid<To, From>& b) {
  const glm::dquat back = glm::conjugate(a.rotation);
  // Subtracting before rotating keeps the precision far from the origin.
  return motion_log(Rigid<From, From>{back * b.rotation, back * (b.translation - a.translation)});
}

}  // namespace farshade
