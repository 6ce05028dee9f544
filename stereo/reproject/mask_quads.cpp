#include "stereo/reproject/mask_quads.h"

#include <algorithm>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

/// The pixel's word, and the lights that differ.
template <class Word>
struct Quad {
  Word bits, differ;
};

/// For each row of blocks, the first pixel column of each block that is not known.
using UnknownBlocks = std::vector<std::vector<std::uint32_t>>;

UnknownBlocks unknown_blocks(const TracedMask& mask, std::size_t eye) {
  const TileGrid grid{mask.masks[eye].size()};
  UnknownBlocks blocks((grid.size.height + kBlockSide_px - 1) / kBlockSide_px);
  for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
    const auto unknown = static_cast<BlockBits>(~known_blocks(mask, eye, tile));
    if (unknown == kNoBlocks) continue;
    const TileRect rect = grid.rect(tile);
    for (std::uint32_t y = rect.y0; y < rect.y1; y += kBlockSide_px)
      for (std::uint32_t x = rect.x0; x < rect.x1; x += kBlockSide_px)
        if ((unknown & block_bit(x - rect.x0, y - rect.y0)) != 0) blocks[y / kBlockSide_px].push_back(x);
  }
  return blocks;
}

/// Writes the quads of row `y` of a plane of a mask.
template <class Word>
void write_row(const Word* words, Extent size, std::uint32_t y, WriteOnly<Quad<Word>> row) {
  const std::size_t w = size.width;
  const bool is_last = y + 1 == size.height;
  constexpr Word kAll = static_cast<Word>(~Word{0});
  const Word *const above = words + y * w, *const below = is_last ? above : above + w;
  row.part(0, w - 1).generate([=, missing = is_last ? kAll : Word{0}](std::size_t x) {
    return Quad<Word>{above[x], static_cast<Word>((above[x] ^ above[x + 1]) | (above[x] ^ below[x]) |
                                                  (above[x] ^ below[x + 1]) | missing)};
  });
  row.write(w - 1, {above[w - 1], kAll});
}

/// Marks the quads of a row that have a pixel of a block of `blocks`.
template <class Word>
void spoil(const std::vector<std::uint32_t>& blocks, std::uint32_t width, Quad<Word>* row) {
  for (const std::uint32_t x : blocks)
    for (std::uint32_t column = std::max(x, 1u) - 1; column < std::min(x + kBlockSide_px, width); ++column)
      row[column].differ = static_cast<Word>(~Word{0});
}

/// A row with unknown blocks is made in ordinary memory, because `out` may be slow to write twice.
template <class Word>
void write(const TracedMask& mask, std::size_t eye, WriteOnly<std::byte> out) {
  const EyeMask& bits = mask.masks[eye];
  const Extent size = bits.size();
  const UnknownBlocks unknown = unknown_blocks(mask, eye);
  const WriteOnly<Quad<Word>> quads = out.as<Quad<Word>>();
  const auto* const words = reinterpret_cast<const Word*>(bits.bytes().data());
  std::vector<Quad<Word>> spoilt(size.width);
  for (std::uint32_t plane = 0; plane < bits.layout().planes(); ++plane)
    for (std::uint32_t y = 0; y < size.height; ++y) {
      const WriteOnly<Quad<Word>> row =
          quads.part((std::size_t{plane} * size.height + y) * size.width, size.width);
      const Word* const of_plane = words + plane * size.pixels();
      const std::size_t own = y / kBlockSide_px,
                        below = std::min<std::size_t>((y + 1) / kBlockSide_px, unknown.size() - 1);
      if (unknown[own].empty() && unknown[below].empty()) {
        write_row(of_plane, size, y, row);
        continue;
      }
      write_row(of_plane, size, y, WriteOnly(std::span(spoilt)));
      spoil(unknown[own], size.width, spoilt.data());
      if (below != own) spoil(unknown[below], size.width, spoilt.data());
      row.copy(spoilt);
    }
}

}  // namespace

void write_quads(const TracedMask& mask, std::size_t eye, WriteOnly<std::byte> out) {
  const EyeMask& bits = mask.masks[eye];
  check_eq(out.size(), quad_bytes(bits.size(), bits.layout()), "bytes of a mask's quads");
  if (bits.size().pixels() == 0) return;
  if (bits.layout().word_bytes() == 1) return write<std::uint8_t>(mask, eye, out);
  if (bits.layout().word_bytes() == 2) return write<std::uint16_t>(mask, eye, out);
  write<std::uint32_t>(mask, eye, out);
}

}  // namespace farshade
