/// Cells: squares of 4x4 bits, and the contexts in which they are coded. A cell is one light in a block of a
/// mask (mask_coder.h), or the requested blocks of a tile (ask_coder.h). Cells are coded row by row from the
/// top left, so a cell knows the cells left of it, above it, and diagonally above it. PROTOCOL.md has the
/// rules.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "stereo/codec/range_coder.h"

namespace farshade {

/// Bit 4 y + x is column x of row y.
using Cell = std::uint16_t;
inline constexpr Cell kEmptyCell = 0, kFullCell = 0xffff;

[[nodiscard]] constexpr bool is_mixed(Cell cell) {
  return cell != kEmptyCell && cell != kFullCell;
}
[[nodiscard]] constexpr Cell cell_of(bool value) {
  return value ? kFullCell : kEmptyCell;
}

/// A cell that may be unknown: outside of the picture, not asked for, or in another slice.
using Neighbour = std::uint32_t;
inline constexpr Neighbour kUnknownCell = 0x10000;

/// A value of a neighbour, as a context.
enum Touch : std::uint32_t { kClear, kSet, kBoth, kUnknown };

/// The values of the bits `mask` of a neighbour.
[[nodiscard]] constexpr Touch touch(Neighbour cell, std::uint32_t mask) {
  if (cell == kUnknownCell) return kUnknown;
  const std::uint32_t bits = cell & mask;
  return bits == 0 ? kClear : bits == mask ? kSet : kBoth;
}

/// A value that is known or not, as one of three contexts.
[[nodiscard]] constexpr std::uint32_t three_of(Touch touched) {
  return touched < kBoth ? static_cast<std::uint32_t>(touched) : 2;
}

inline constexpr std::uint32_t kLastColumn = 0x8888, kLastRow = 0xf000;
inline constexpr std::uint32_t kUpperRight = 0x0008, kLowerLeft = 0x1000, kLowerRight = 0x8000;

/// The cells around a cell.
struct Neighbours {
  Neighbour west = kUnknownCell, north = kUnknownCell, north_west = kUnknownCell, north_east = kUnknownCell;
};

/// The rows above a cell and the columns left of it. Bit 0 and 1 of a row are the two bits left of the cell,
/// bits 2 to 5 the cell, bits 6 and 7 the two bits right of it. An unknown cell north is filled with the
/// upper right bit of the cell west (or 0); then an unknown cell west with the lower left bit of the cell
/// north, an unknown one north-west with the same, and one north-east with the lower right bit of the cell
/// north.
struct Border {
  std::uint32_t west, above, above_2;

  explicit constexpr Border(const Neighbours& around) {
    const auto fill = [](bool value) { return std::uint32_t{cell_of(value)}; };
    const auto known = [](Neighbour cell) { return cell != kUnknownCell; };
    const bool west_bit = known(around.west) && (around.west >> 3 & 1) != 0;
    const std::uint32_t north = known(around.north) ? around.north : fill(west_bit);
    west = known(around.west) ? around.west : fill((north & kLowerLeft) != 0);
    const std::uint32_t nw = known(around.north_west) ? around.north_west : fill((north & kLowerLeft) != 0);
    const std::uint32_t ne = known(around.north_east) ? around.north_east : fill((north & kLowerRight) != 0);
    above = (nw >> 14 & 3) | (north >> 12 & 15) << 2 | (ne >> 12 & 3) << 6;
    above_2 = (nw >> 10 & 3) | (north >> 8 & 15) << 2 | (ne >> 8 & 3) << 6;
  }
  /// The two bits left of row y: bit 1 is the nearer.
  [[nodiscard]] constexpr std::uint32_t left_of(std::uint32_t y) const { return west >> (4 * y + 2) & 3; }
  /// Goes on to the next row. `row` has bits 0 to 5; the unknown bits right of it repeat its last.
  constexpr void below(std::uint32_t row) {
    above_2 = above;
    above = row | (row >> 5 & 1) * 0xc0;
  }
};

/// The context of bit x of a row: the six bits W W, W, N W, N, N E, N N of which bit 0 is WW. `row` has the
/// bits left of x.
[[nodiscard]] constexpr std::uint32_t bit_context(std::uint32_t row, const Border& border, std::uint32_t x) {
  return (row >> x & 3) | (border.above >> (x + 1) & 7) << 2 | (border.above_2 >> (x + 2) & 1) << 5;
}
inline constexpr std::uint32_t kBitContexts = 64;

}  // namespace farshade
