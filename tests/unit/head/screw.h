/// A motion that most tests of filters use, and the difference of two poses as one number.
#pragma once

#include <glm/geometric.hpp>

#include "stereo/head/kalman_filter.h"
#include "stereo/math/rotation.h"
#include "stereo/math/twist.h"

namespace farshade {

inline const Twist kScrew{{0.4, -2.0, 0.3}, {0.5, 0.1, -1.2}};  ///< a fast turn while walking

/// Radians plus metres.
inline double error_of(const HeadPose& a, const HeadPose& b) {
  return angle_between_rad(a.rotation, b.rotation) + glm::length(a.translation - b.translation);
}

}  // namespace farshade
