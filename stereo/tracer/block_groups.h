/// The tracer's work list: the requested blocks of a view, in groups of up to 256 pixels that are traced
/// together.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "stereo/frame/requested_blocks.h"

namespace farshade {

inline constexpr int kBlockPixels = static_cast<int>(kBlockSide_px * kBlockSide_px);
inline constexpr int kGroupBlocks = static_cast<int>(kTileBlocks * kTileBlocks);

/// A block's first pixel, in pixels of the view.
struct BlockPlace {
  std::uint16_t x, y;
  friend bool operator==(BlockPlace, BlockPlace) = default;
};

/// Blocks that lie close to each other, so that their bounds are tight. In a whole view each tile is a group,
/// with its blocks in the order of BlockBits, also those outside of the picture.
struct BlockGroup {
  std::array<BlockPlace, kGroupBlocks> blocks{};
  int count = 0;
  RequestedTile requested{};  ///< bit i of a share: it is asked for in block i of the group
};

/// The groups of a view of `size` pixels, for masks of `lights` lights. `requested` has one entry per tile,
/// or none for the whole view.
[[nodiscard]] std::vector<BlockGroup> groups_of(Extent size, std::uint32_t lights,
                                                std::span<const RequestedTile> requested);

/// The group of one whole tile.
[[nodiscard]] BlockGroup group_of(const TileRect& rect, std::uint32_t lights);

}  // namespace farshade
