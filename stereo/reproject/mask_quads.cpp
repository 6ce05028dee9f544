#include "stereo/reproject/mask_quads.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

/// The pixel's word, and the lights that differ.
template <class Word>
struct Quad {
  Word bits, differ;
};

/// The quads of a plane of a mask.
template <class Word>
void write_plane(const Word* words, Extent size, Quad<Word>* quads) {
  const std::size_t w = size.width;
  constexpr Word kAll = static_cast<Word>(~Word{0});
  for (std::size_t y = 0; y < size.height; ++y) {
    const Word *const above = words + y * w, *const below = y + 1 < size.height ? above + w : above;
    Quad<Word>* const row = quads + y * w;
    for (std::size_t x = 0; x + 1 < w; ++x)
      row[x] = {above[x], static_cast<Word>((above[x] ^ above[x + 1]) | (above[x] ^ below[x]) |
                                            (above[x] ^ below[x + 1]))};
    row[w - 1] = {above[w - 1], kAll};
    if (y + 1 == size.height)
      for (std::size_t x = 0; x < w; ++x) row[x].differ = kAll;
  }
}

/// Marks the quads that have a pixel of the block at (x, y).
template <class Word>
void spoil_block(std::uint32_t x, std::uint32_t y, Extent size, Quad<Word>* quads) {
  const std::uint32_t left = std::max(x, 1u) - 1, right = std::min(x + kBlockSide_px, size.width);
  for (std::uint32_t row = std::max(y, 1u) - 1; row < std::min(y + kBlockSide_px, size.height); ++row)
    for (std::uint32_t column = left; column < right; ++column)
      quads[std::size_t{row} * size.width + column].differ = static_cast<Word>(~Word{0});
}

template <class Word>
void write(const TracedMask& mask, std::size_t eye, std::span<std::byte> out) {
  const EyeMask& bits = mask.masks[eye];
  const TileGrid grid{bits.size()};
  auto* const quads = reinterpret_cast<Quad<Word>*>(out.data());
  const auto* const words = reinterpret_cast<const Word*>(bits.bytes().data());
  for (std::uint32_t plane = 0; plane < bits.layout().planes(); ++plane) {
    const std::size_t first = plane * bits.size().pixels();
    write_plane(words + first, bits.size(), quads + first);
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      const auto unknown = static_cast<BlockBits>(~known_blocks(mask, eye, tile));
      if (unknown == kNoBlocks) continue;
      const TileRect rect = grid.rect(tile);
      for (std::uint32_t y = rect.y0; y < rect.y1; y += kBlockSide_px)
        for (std::uint32_t x = rect.x0; x < rect.x1; x += kBlockSide_px)
          if ((unknown & block_bit(x - rect.x0, y - rect.y0)) != 0)
            spoil_block(x, y, bits.size(), quads + first);
    }
  }
}

}  // namespace

void write_quads(const TracedMask& mask, std::size_t eye, std::span<std::byte> out) {
  const EyeMask& bits = mask.masks[eye];
  check_eq(out.size(), quad_bytes(bits.size(), bits.layout()), "bytes of a mask's quads");
  if (bits.size().pixels() == 0) return;
  if (bits.layout().word_bytes() == 1) return write<std::uint8_t>(mask, eye, out);
  if (bits.layout().word_bytes() == 2) return write<std::uint16_t>(mask, eye, out);
  write<std::uint32_t>(mask, eye, out);
}

}  // namespace farshade
