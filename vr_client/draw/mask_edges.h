/// Mask edges: a mask as the device holds it has one bit more than there are lights: whether the pixel and
/// its eight neighbours differ in any light. Only there is it worth asking what lies between pixels.
#pragma once

#include <span>

#include "stereo/frame/eye_mask.h"

namespace farshade {

/// Of a device mask: bit `lights` is the edge.
[[nodiscard]] constexpr MaskLayout with_edge_bit(MaskLayout mask) {
  return {mask.lights + 1};
}
static_assert(with_edge_bit({kMaxLights}).planes() == kMaxLights / 32 + 1);

/// Bytes of a mask of `size` that lies as `layout` says.
[[nodiscard]] constexpr std::size_t mask_bytes(Extent size, MaskLayout layout) {
  return size.pixels() * layout.planes() * layout.word_bytes();
}

/// Writes `mask` with its edges to `out`, mask_bytes(mask.size(), with_edge_bit(mask.layout())) bytes.
void copy_with_edges(const EyeMask& mask, std::span<std::byte> out);

}  // namespace farshade
