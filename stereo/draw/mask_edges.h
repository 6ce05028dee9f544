/// Mask edges: a mask as the device holds it has four bits more than there are lights. They say of each
/// quarter of a pixel whether the 2x2 pixels around its corner differ in any light: only there is it worth
/// asking what lies between pixels.
#pragma once

#include <span>

#include "stereo/frame/eye_mask.h"

namespace farshade {

/// The four bits, in the order of the pixel's quarters: upper left, upper right, lower left, lower right.
/// They lie in one plane.
[[nodiscard]] constexpr std::uint32_t first_edge_bit(std::uint32_t lights) {
  return lights % 32 <= 28 ? lights : (lights + 31) / 32 * 32;
}
[[nodiscard]] constexpr MaskLayout with_edge_bits(MaskLayout mask) {
  return {first_edge_bit(mask.lights) + 4, mask.least_word_bytes};
}
static_assert(with_edge_bits({3}).word_bytes() == 1 && with_edge_bits({kMaxLights}).planes() == 9);

/// Bytes of a mask of `size` that lies as `layout` says.
[[nodiscard]] constexpr std::size_t mask_bytes(Extent size, MaskLayout layout) {
  return size.pixels() * layout.planes() * layout.word_bytes();
}

/// Writes `mask` with its edges to `out`, mask_bytes(mask.size(), with_edge_bits(mask.layout())) bytes.
void copy_with_edges(const EyeMask& mask, std::span<std::byte> out);

}  // namespace farshade
