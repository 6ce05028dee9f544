/// KnownTiles: which tiles of a mask have arrived. What has not arrived is unknown, never a guess in
/// disguise.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "stereo/frame/eye_mask.h"

namespace farshade {

/// A byte a tile (TileGrid order), its bit p = the tile's plane p is known. So a mask of up to 32 lights has
/// 0 and 1; one of more has all_planes_known() where no plane is missing.
using KnownTiles = std::vector<std::uint8_t>;
static_assert(MaskLayout{kMaxLights}.planes() <= 8);

[[nodiscard]] constexpr std::uint8_t all_planes_known(MaskLayout layout) {
  return static_cast<std::uint8_t>((1u << layout.planes()) - 1);
}

/// No plane of any tile is missing.
[[nodiscard]] inline bool is_whole(const KnownTiles& tiles, MaskLayout layout) {
  return std::all_of(tiles.begin(), tiles.end(),
                     [all = all_planes_known(layout)](std::uint8_t tile) { return tile == all; });
}

}  // namespace farshade
