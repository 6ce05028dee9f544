/// ReceivedTiles: the tiles of a mask that have arrived. A requested block of a tile that has not arrived is
/// unknown; its visibility is never guessed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "stereo/frame/eye_mask.h"

namespace farshade {

/// One byte per tile (TileGrid order). Bit p is set if plane p of the tile is known. A tile of a mask with up
/// to 32 lights is 0 or 1; a complete tile is all_planes_received().
using ReceivedTiles = std::vector<std::uint8_t>;
static_assert(MaskLayout{kMaxLights}.planes() <= 8);

[[nodiscard]] constexpr std::uint8_t all_planes_received(MaskLayout layout) {
  return static_cast<std::uint8_t>((1u << layout.planes()) - 1);
}

/// Whether one of the tiles [first, first + count) is known in one of the planes `planes`. Slices of an
/// honest sender have each tile once. So a slice with a received tile is a duplicate, and is not worth
/// decoding: it could cost the same work again and again.
[[nodiscard]] inline bool is_any_received(const ReceivedTiles& known, std::uint32_t first,
                                          std::uint32_t count, std::uint8_t planes) {
  return std::ranges::any_of(std::span(known).subspan(first, count),
                             [planes](std::uint8_t tile) { return (tile & planes) != 0; });
}

}  // namespace farshade
