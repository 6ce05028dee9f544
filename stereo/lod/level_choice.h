/// Level choice: how large an error of an instance appears in a view, and which level is fine enough for it.
#pragma once

#include <glm/mat4x4.hpp>
#include <span>

#include "stereo/frame/view.h"
#include "stereo/lod/levels.h"

namespace farshade {

/// An upper bound for the pixels by which a visible point of `box` moves when it moves by one unit of object
/// space. `clip_from_object` maps to Vulkan's clip space; `size` is the picture's. Infinity if the eye is in
/// the box.
[[nodiscard]] double pixels_per_unit(const glm::dmat4& clip_from_object, const Bounds& box, Extent size);

/// A level is replaced by a coarser one only if that one's error stays below this share of the limit, so that
/// small movements do not switch to and fro.
inline constexpr double kHysteresis = 0.75;

/// The number of the coarsest level, 1 for levels[0] and 0 for the mesh itself, whose error is at most
/// `most_px` pixels. `previous` is the last choice for the same instance and pass.
[[nodiscard]] std::uint32_t choose_level(std::span<const DetailLevel> levels, double px_per_unit,
                                         double most_px, std::uint32_t previous);

}  // namespace farshade
