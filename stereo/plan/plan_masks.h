/// What a plan says about the masks that its client holds.
#pragma once

#include <cstddef>

#include "stereo/frame/cube_mask.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {

/// Whether masks are reprojected to views other than the traced ones. Otherwise they are read at the shown
/// pixel.
[[nodiscard]] constexpr bool reprojects_masks(const DrawPlan& plan) {
  return plan.depth_pass && plan.mask.lights > 0;
}

/// The number of masks of the cube's faces that the device holds.
[[nodiscard]] constexpr std::size_t most_cube_mask_pairs(const DrawPlan& plan) {
  return reprojects_masks(plan) && plan.cube_mask ? kCubeMaskPairs : 0;
}

}  // namespace farshade
