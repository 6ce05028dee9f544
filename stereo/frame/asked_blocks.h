/// AskedBlocks: the part of both views that a request asks for. A client asks only for what it cannot carry
/// over from earlier masks (docs/asking.md). The unit is a block of 4x4 pixels: as many as a packet has rays.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "stereo/frame/tiles.h"
#include "stereo/frame/view.h"

namespace farshade {

inline constexpr std::uint32_t kBlockSide_px = 4;
inline constexpr std::uint32_t kTileBlocks = kTileSide_px / kBlockSide_px;  ///< along each side of a tile

/// The blocks of one tile: bit kTileBlocks * row + column. Bits of blocks outside of the picture mean
/// nothing.
using BlockBits = std::uint16_t;
inline constexpr BlockBits kNoBlocks = 0, kAllBlocks = 0xffff;
static_assert(kTileBlocks * kTileBlocks == 16);

/// The bit of the block that contains pixel (x, y) of a tile.
[[nodiscard]] constexpr BlockBits block_bit(std::uint32_t x, std::uint32_t y) {
  return static_cast<BlockBits>(1u << (kTileBlocks * (y / kBlockSide_px) + x / kBlockSide_px));
}

/// For each eye one entry per tile (TileGrid order). An eye without entries is asked for as a whole.
struct AskedBlocks {
  PerEye<std::vector<BlockBits>> tiles;

  /// The blocks of a tile.
  [[nodiscard]] BlockBits at(std::size_t eye, std::size_t tile) const {
    return tiles[eye].empty() ? kAllBlocks : tiles[eye][tile];
  }
  /// Both eyes are asked for as a whole.
  [[nodiscard]] bool whole() const { return tiles[0].empty() && tiles[1].empty(); }
  friend bool operator==(const AskedBlocks&, const AskedBlocks&) = default;
};

/// The share of the blocks of both eyes that is asked for: 1 if these are whole views. Blocks outside of the
/// pictures count, too.
[[nodiscard]] inline double share_of(const AskedBlocks& asked) {
  std::size_t blocks = 0, tiles = 0;
  for (const std::vector<BlockBits>& eye : asked.tiles) {
    tiles += eye.size();
    for (const BlockBits bits : eye) blocks += static_cast<std::size_t>(std::popcount(bits));
  }
  return asked.whole() ? 1
                       : static_cast<double>(blocks) / static_cast<double>(tiles * kTileBlocks * kTileBlocks);
}

}  // namespace farshade
