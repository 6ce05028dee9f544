/// Mask edges: where a shadow edge may be between the pixels of a mask. The cell of a pixel lies between it
/// and its right, lower and lower right neighbours. A light has an edge in a cell if the four pixels differ;
/// with edge rays also if a shadow or gap of one pixel's width ends near the cell, or passes it, since
/// that may go on between pixels. Cells at the right and lower border do not have four pixels, and have no
/// edge. A mask on the device has four bits per pixel beside those of the lights, one for each quarter of the
/// pixel. Such a bit is 1 if the cell at the quarter's corner has an edge in any light. Only there does
/// shade.comp look between pixels.
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

/// Bytes of a mask with its edge bits, and of a word for each plane of lights and pixel with the lights that
/// have an edge in the pixel's cell.
[[nodiscard]] constexpr std::size_t mask_and_cell_bytes(Extent size, MaskLayout mask) {
  const MaskLayout device = with_edge_bits(mask);
  return mask_bytes(size, device) + size.pixels() * mask.planes() * device.word_bytes();
}

/// Writes a mask for edge rays to `out`, which has mask_and_cell_bytes(mask.size(), mask.layout()) bytes.
/// Thin shadows and gaps count in the lights `thin`.
void copy_with_cells(const EyeMask& mask, const LightBits& thin, WriteOnly<std::byte> out);

}  // namespace farshade
