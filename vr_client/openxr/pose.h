/// Poses of OpenXR as rigid transforms.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "stereo/math/spaces.h"
#include "vr_client/openxr/openxr.h"
#include "vr_client/runtime/hands.h"

namespace farshade::openxr {

inline constexpr XrPosef kOrigin{{0, 0, 0, 1}, {0, 0, 0}};

/// Some runtimes say that a pose is valid and give numbers that are no pose, for example a quaternion of
/// zeros before the first measurement.
[[nodiscard]] inline bool is_pose(const XrPosef& pose) {
  const auto& [q, p] = pose;
  const double norm = double{q.x} * q.x + double{q.y} * q.y + double{q.z} * q.z + double{q.w} * q.w;
  return norm > 0.25 && norm < 4 &&
         std::ranges::all_of(std::array{p.x, p.y, p.z}, [](float value) { return std::isfinite(value); });
}

/// Of a pose for which is_pose() holds. Runtimes round quaternions to floats.
template <class From>
[[nodiscard]] Rigid<Tracked, From> rigid(const XrPosef& pose) {
  return {glm::normalize(
              glm::dquat(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z)),
          {pose.position.x, pose.position.y, pose.position.z}};
}

}  // namespace farshade::openxr
