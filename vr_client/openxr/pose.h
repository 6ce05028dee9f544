/// Poses of OpenXR as rigid transforms.
#pragma once

#include "stereo/math/spaces.h"
#include "vr_client/openxr/openxr.h"
#include "vr_client/runtime/hands.h"

namespace farshade::openxr {

inline constexpr XrPosef kOrigin{{0, 0, 0, 1}, {0, 0, 0}};

/// Runtimes round quaternions to floats.
template <class From>
[[nodiscard]] Rigid<Tracked, From> rigid(const XrPosef& pose) {
  return {glm::normalize(
              glm::dquat(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z)),
          {pose.position.x, pose.position.y, pose.position.z}};
}

}  // namespace farshade::openxr
