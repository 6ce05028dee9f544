#include "stereo/tracer/block_groups.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// Only blocks of the same square of tiles share a group. Squares of 1, 2, 4 and 8 tiles and whole rows of
/// tiles took the same time within 2 % (edge blocks of living room and room.glb).
constexpr std::uint32_t kSquareTiles = 4;

/// Bits of the blocks that touch the picture.
BlockBits blocks_inside(const TileRect& rect) {
  BlockBits inside = kNoBlocks;
  for (std::uint32_t y = 0; y < rect.y1 - rect.y0; y += kBlockSide_px)
    for (std::uint32_t x = 0; x < rect.x1 - rect.x0; x += kBlockSide_px) inside |= block_bit(x, y);
  return inside;
}

/// Appends the blocks `bits` of a tile, with the shares that are asked for there.
void append(BlockBits bits, const RequestedTile& requested, const TileRect& rect, BlockGroup& group) {
  for (std::uint32_t block = 0; block < kGroupBlocks; ++block) {
    if ((bits >> block & 1u) == 0) continue;
    for (std::uint32_t share = 0; share < kMostShares; ++share)
      group.requested.shares[share] |=
          static_cast<BlockBits>((requested.shares[share] >> block & 1u) << group.count);
    group.blocks[static_cast<std::size_t>(group.count++)] = {
        static_cast<std::uint16_t>(rect.x0 + block % kTileBlocks * kBlockSide_px),
        static_cast<std::uint16_t>(rect.y0 + block / kTileBlocks * kBlockSide_px)};
  }
}

/// Fills groups with the blocks of one square after the other.
class Grouping {
 public:
  Grouping(Extent size, std::span<const RequestedTile> requested) : grid_{size}, requested_(requested) {}

  /// Adds the requested blocks of the square of tiles that begins at (left, top).
  void add_square(std::uint32_t left, std::uint32_t top) {
    for (std::uint32_t row = top; row < std::min(top + kSquareTiles, grid_.rows()); ++row)
      for (std::uint32_t column = left; column < std::min(left + kSquareTiles, grid_.columns()); ++column)
        add_tile(row * grid_.columns() + column);
    close();
  }
  [[nodiscard]] std::vector<BlockGroup> take() { return std::move(groups_); }

 private:
  void add_tile(std::uint32_t tile) {
    const TileRect rect = grid_.rect(tile);
    const auto bits = static_cast<BlockBits>(requested_[tile].any() & blocks_inside(rect));
    if (open_.count + std::popcount(bits) > kGroupBlocks) close();
    append(bits, requested_[tile], rect, open_);
  }
  void close() {
    if (open_.count > 0) groups_.push_back(open_);
    open_ = {};
  }

  TileGrid grid_;
  std::span<const RequestedTile> requested_;
  BlockGroup open_;
  std::vector<BlockGroup> groups_;
};

}  // namespace

BlockGroup group_of(const TileRect& rect, std::uint32_t lights) {
  BlockGroup group;
  append(kAllBlocks, all_lights_in(kAllBlocks, lights), rect, group);
  return group;
}

std::vector<BlockGroup> groups_of(Extent size, std::uint32_t lights,
                                  std::span<const RequestedTile> requested) {
  const TileGrid grid{size};
  if (requested.empty()) {
    std::vector<BlockGroup> groups;
    groups.reserve(grid.count());
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile)
      groups.push_back(group_of(grid.rect(tile), lights));
    return groups;
  }
  check_eq(requested.size(), std::size_t{grid.count()}, "a set of blocks for each tile");
  Grouping grouping(size, requested);
  for (std::uint32_t top = 0; top < grid.rows(); top += kSquareTiles)
    for (std::uint32_t left = 0; left < grid.columns(); left += kSquareTiles) grouping.add_square(left, top);
  return grouping.take();
}

}  // namespace farshade
