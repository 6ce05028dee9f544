/// Mask edges: a mask on the device has four bits per pixel beside those of the lights, one for each quarter
/// of the pixel. Such a bit is 1 if the 2x2 pixels around the quarter's corner differ in any light. Only
/// there does shade.comp filter the visibility between pixels.
#pragma once

#include "stereo/base/write_only.h"
#include "stereo/frame/eye_mask.h"

namespace farshade {

/// The first of the four bits. Their order is upper left, upper right, lower left, lower right. All four are
/// in one plane.
[[nodiscard]] constexpr std::uint32_t first_edge_bit(std::uint32_t lights) {
  return lights % 32 <= 28 ? lights : (lights + 31) / 32 * 32;
}
[[nodiscard]] constexpr MaskLayout with_edge_bits(MaskLayout mask) {
  return {first_edge_bit(mask.lights) + 4, mask.least_word_bytes};
}
static_assert(with_edge_bits({3}).word_bytes() == 1 && with_edge_bits({kMaxLights}).planes() == 9);

/// Bytes of a mask of `size` in `layout`.
[[nodiscard]] constexpr std::size_t mask_bytes(Extent size, MaskLayout layout) {
  return size.pixels() * layout.planes() * layout.word_bytes();
}

/// Writes `mask` with its edge bits to `out`, which has mask_bytes(mask.size(),
/// with_edge_bits(mask.layout())) bytes.
void copy_with_edges(const EyeMask& mask, WriteOnly<std::byte> out);

}  // namespace farshade
