/// TileBits: one plane (up to 32 lights) of one 16x16 tile of a mask, light by light in cells of 4x4 pixels.
#pragma once

#include <array>
#include <cstdint>

#include "stereo/frame/asked_blocks.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/cells.h"

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

/// Reads the blocks `asked` of a tile from a mask, or writes them to it; other pixels do not count, and do
/// not change. `rect` is a tile of the mask's TileGrid.
void split_tile(const EyeMask& mask, TileRect rect, std::uint32_t plane, BlockBits asked, TileBits& bits);
void merge_tile(const TileBits& bits, TileRect rect, std::uint32_t plane, BlockBits asked, EyeMask& mask);

}  // namespace farshade
