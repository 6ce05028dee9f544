/// The surfaces that the pixels of a tile see, or those of a group of blocks (block_groups.h). Pixels are
/// stored in 4x4 blocks, so that the 16 rays of a packet are close to each other.
#pragma once

#include <array>
#include <cstdint>

#include "stereo/frame/tiles.h"

namespace farshade {

inline constexpr int kTilePixels = static_cast<int>(kTileSide_px * kTileSide_px);

/// Position of a pixel in its tile. kTileOrder lists the pixels in block order. Its first 16 entries are also
/// the positions in a block.
struct TilePixel {
  std::uint8_t x, y;
};
inline constexpr std::array<TilePixel, kTilePixels> kTileOrder = [] {
  std::array<TilePixel, kTilePixels> order{};
  for (int i = 0; i < kTilePixels; ++i) {
    const int block = i / 16, lane = i % 16;
    order[static_cast<std::size_t>(i)] = {static_cast<std::uint8_t>(block % 4 * 4 + lane % 4),
                                          static_cast<std::uint8_t>(block / 4 * 4 + lane / 4)};
  }
  return order;
}();

/// Shadow rays start above their surface by this share of the largest coordinate. Derived in tile_stages.h.
inline constexpr float kOffset = 64.0f / (1 << 24);

/// In block order, in anchor space: element i is pixel i % 16 of the group's block i / 16. Normals are turned
/// as the definition in tracer.h says, and zero where no surface covers the pixel.
struct alignas(64) TileSurface {
  float px[kTilePixels], py[kTilePixels], pz[kTilePixels];
  float ox[kTilePixels], oy[kTilePixels], oz[kTilePixels];  ///< where shadow rays start
  float nx[kTilePixels], ny[kTilePixels], nz[kTilePixels];  ///< shading normal, any length
  float gx[kTilePixels], gy[kTilePixels], gz[kTilePixels];  ///< geometric normal, unit
  float reach[kTilePixels];                                 ///< Facet::reach; 0 = not covered
  int pixels = kTilePixels;                                 ///< used elements, a multiple of 16
  std::uint32_t covered = 0;                                ///< number of covered pixels
};

}  // namespace farshade
