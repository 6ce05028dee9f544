/// RequestedBlocks: the part of both views that a request asks for. A client asks only for what it cannot
/// reproject from earlier masks (docs/partial-requests.md). The unit is one share of the lights in a block of
/// 4x4 pixels: as many as a packet has rays.
#pragma once

#include <algorithm>
#include <array>
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

/// Lights are asked for in up to eight shares: share s has the lights s, s + 8, s + 16, and so on. So it is
/// bit s of each byte of a mask word, and up to eight lights have a share each.
inline constexpr std::uint32_t kMostShares = 8;

/// Number of shares of so many lights. Masks without a light have one share, too.
[[nodiscard]] constexpr std::uint32_t shares_of(std::uint32_t lights) {
  return std::clamp(lights, 1u, kMostShares);
}

/// The requested blocks of one tile, share by share. Shares that the mask does not have are empty.
struct RequestedTile {
  std::array<BlockBits, kMostShares> shares{};

  /// The blocks that are asked for in light `light` of the mask.
  [[nodiscard]] constexpr BlockBits of(std::uint32_t light) const { return shares[light % kMostShares]; }
  /// The blocks that are asked for in any light.
  [[nodiscard]] constexpr BlockBits any() const {
    BlockBits blocks = kNoBlocks;
    for (const BlockBits share : shares) blocks |= share;
    return blocks;
  }
  /// The shares of a block as bits.
  [[nodiscard]] constexpr std::uint8_t at(std::uint32_t block) const {
    std::uint32_t bits = 0;
    for (std::uint32_t share = 0; share < kMostShares; ++share)
      bits |= (shares[share] >> block & 1u) << share;
    return static_cast<std::uint8_t>(bits);
  }
  /// Asks for these shares of a block.
  constexpr void add(std::uint32_t block, std::uint32_t bits) {
    for (std::uint32_t share = 0; bits >> share != 0; ++share)
      shares[share] |= static_cast<BlockBits>((bits >> share & 1u) << block);
  }
  friend bool operator==(const RequestedTile&, const RequestedTile&) = default;
};

/// Asks for all lights in these blocks.
[[nodiscard]] constexpr RequestedTile all_lights_in(BlockBits blocks, std::uint32_t lights) {
  RequestedTile tile;
  for (std::uint32_t share = 0; share < shares_of(lights); ++share) tile.shares[share] = blocks;
  return tile;
}

/// For each eye one entry per tile (TileGrid order). An eye without entries is asked for as a whole.
struct RequestedBlocks {
  PerEye<std::vector<RequestedTile>> tiles;
  std::uint32_t lights = 0;  ///< of the masks; means nothing for whole views

  /// The blocks of a tile that are asked for in any light.
  [[nodiscard]] BlockBits at(std::size_t eye, std::size_t tile) const {
    return tiles[eye].empty() ? kAllBlocks : tiles[eye][tile].any();
  }
  /// Both eyes are asked for as a whole.
  [[nodiscard]] bool whole() const { return tiles[0].empty() && tiles[1].empty(); }
  friend bool operator==(const RequestedBlocks&, const RequestedBlocks&) = default;
};

/// The part of both eyes' masks that is asked for: 1 if these are whole views. Blocks outside of the pictures
/// count, too.
[[nodiscard]] inline double part_of(const RequestedBlocks& requested) {
  std::size_t cells = 0, tiles = 0;
  for (const std::vector<RequestedTile>& eye : requested.tiles) {
    tiles += eye.size();
    for (const RequestedTile& tile : eye)
      for (const BlockBits share : tile.shares) cells += static_cast<std::size_t>(std::popcount(share));
  }
  const std::size_t all = tiles * kTileBlocks * kTileBlocks * shares_of(requested.lights);
  return requested.whole() ? 1 : static_cast<double>(cells) / static_cast<double>(all);
}

}  // namespace farshade
