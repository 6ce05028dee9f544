/// Mask quads: the form in which request_reprojection.comp reads a mask. For each pixel it has the bits of
/// the pixel, and the lights that differ in the quad of the pixel and its three neighbours to the right and
/// below. So the shader reads one place instead of four.
#pragma once

#include "stereo/base/write_only.h"
#include "stereo/reproject/reprojection.h"

namespace farshade {

/// Bytes of the quads of a mask of `size`: like the mask, but with two words for each pixel.
[[nodiscard]] constexpr std::size_t quad_bytes(Extent size, MaskLayout layout) {
  return 2 * size.pixels() * layout.planes() * layout.word_bytes();
}

/// Writes the quads of an eye of `mask` to `out`, which has quad_bytes(). All lights of a quad differ if it
/// has a pixel of a block that is not known, or less than four pixels: the last row and column.
void write_quads(const TracedMask& mask, std::size_t eye, WriteOnly<std::byte> out);

}  // namespace farshade
