/// The motion data of shade.comp: the lights and instances that have moved since the masks in use were
/// traced. Pure; no device needed.
#pragma once

#include <span>

#include "shaders/shared.h"
#include "stereo/base/write_only.h"
#include "stereo/frame/view.h"
#include "stereo/reproject/motion.h"

namespace farshade {

/// The motion since each mask in use was traced.
struct MaskMotions {
  std::span<const Motion* const> masks{};      ///< newest mask first; at most FARSHADE_MAX_MASKS
  std::span<const Motion* const> cube_mask{};  ///< at most FARSHADE_MAX_CUBE_MASK_PAIRS
};

/// Index of a matrix in the buffer `motions` of motion.glsl. `slot` counts from 0. The masks of the cube's
/// faces follow from index FARSHADE_MAX_MASKS on.
[[nodiscard]] constexpr std::size_t motion_index(std::size_t slot, std::size_t mask, std::size_t eye) {
  return (slot * FARSHADE_MAX_TRACED + mask) * kEyes + eye;
}

/// Writes, for each mask, the matrix that moves a point on the instance of `slot` to where it was then, in
/// each shown eye's space. Element [0][3] is a flag: 1 if the instance has moved since any mask of the same
/// group (FARSHADE_SINCE_*) was traced.
void write_motions(const StereoView& views, const MaskMotions& since, std::size_t slot,
                   WriteOnly<glm::mat4> matrices);

/// Writes spheres relative to each eye, kMostSpheres an eye; those that are not used have a negative
/// radius^2.
void write_spheres(const StereoView& views, std::span<const Sphere> spheres, std::span<gpu::vec4> into);

/// Writes the lights that are stale and the bounding spheres of moved instances to `frame`. Returns whether
/// anything has moved since a mask in use was traced.
bool write_stale(const StereoView& views, const MaskMotions& since, gpu::FrameData& frame);

}  // namespace farshade
