/// Tiles: squares of 16x16 pixels. Masks are traced, packed, sent and tracked as known or unknown per tile.
#pragma once

#include <algorithm>
#include <cstdint>

#include "stereo/base/extent.h"

namespace farshade {

inline constexpr std::uint32_t kTileSide_px = 16;

struct TileRect {
  std::uint32_t x0, y0, x1, y1;  ///< pixels, end exclusive; tiles at the right and bottom may be smaller
};

/// The tiles of a picture, numbered row by row from the top left.
struct TileGrid {
  Extent size;  ///< pixels

  [[nodiscard]] constexpr std::uint32_t columns() const {
    return (size.width + kTileSide_px - 1) / kTileSide_px;
  }
  [[nodiscard]] constexpr std::uint32_t rows() const {
    return (size.height + kTileSide_px - 1) / kTileSide_px;
  }
  [[nodiscard]] constexpr std::uint32_t count() const { return columns() * rows(); }
  [[nodiscard]] constexpr TileRect rect(std::uint32_t tile) const {
    const std::uint32_t x0 = tile % columns() * kTileSide_px, y0 = tile / columns() * kTileSide_px;
    return {x0, y0, std::min(x0 + kTileSide_px, size.width), std::min(y0 + kTileSide_px, size.height)};
  }
};

}  // namespace farshade
