/// The mip levels of an sRGB texture, by a box filter in linear light.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// Levels of a full chain, the largest included: the last one has one pixel. `size` has no side of 0.
[[nodiscard]] std::uint32_t mip_count(Extent size);

/// The size of the level after one of `size`.
[[nodiscard]] Extent next_mip(Extent size);

/// The pixels of a full chain, the largest level included.
[[nodiscard]] std::size_t mip_pixels(Extent size);

/// The pixels of all levels but the largest, one level after the other. Each pixel is the mean of the area
/// that it covers in the level before; alpha is already linear. Odd sides: Guthe and Heckbert,
/// "Non-Power-of-Two Mipmapping", NVIDIA 2005. `largest` has no side of 0.
[[nodiscard]] std::vector<Rgba8> smaller_levels(const Image<Rgba8>& largest);

}  // namespace farshade
