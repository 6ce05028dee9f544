/// TileBits: one plane (up to 32 lights) of one 16x16 tile of a mask, light by light in cells of 4x4 pixels.
#pragma once

#include <array>
#include <cstdint>

#include "stereo/codec/cells.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/requested_blocks.h"
#include "stereo/frame/tiles.h"

namespace farshade {

/// One light in one tile: a cell for each block (BlockBits order). Pixels outside of the mask repeat its last
/// column and row.
using TileCells = std::array<Cell, 16>;

/// Bit i of the words is light 32 * plane + i.
struct TileBits {
  std::uint32_t varies = 0;           ///< lights that differ between pixels
  std::uint32_t value = 0;            ///< value of the other lights; 0 for lights that vary
  std::array<TileCells, 32> cells{};  ///< of the lights that vary; others mean nothing
};

/// The blocks of a tile that are at least partly inside the picture.
[[nodiscard]] BlockBits blocks_in(TileRect rect);

/// The lights of a plane of `lights` lights that some block of a tile is asked for in.
[[nodiscard]] constexpr std::uint32_t lights_requested(const RequestedTile& requested, std::uint32_t lights) {
  std::uint32_t shares = 0;
  for (std::uint32_t share = 0; share < kMostShares; ++share)
    shares |= (requested.shares[share] != kNoBlocks ? 0x01010101u : 0u) << share;
  return lights < 32 ? shares & ((1u << lights) - 1) : shares;
}

/// Reads a tile from a mask, or writes it to it: of each light the blocks that are asked for in it. The rest
/// does not count, and does not change. A light that no block is asked for in does not vary and has the value
/// 0. `rect` is a tile of the mask's TileGrid.
void split_tile(const EyeMask& mask, TileRect rect, std::uint32_t plane, const RequestedTile& requested,
                TileBits& bits);
void merge_tile(const TileBits& bits, TileRect rect, std::uint32_t plane, const RequestedTile& requested,
                EyeMask& mask);

}  // namespace farshade
