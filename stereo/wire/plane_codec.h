/// Plane codec: a plane of pixels as slices that each decode alone, as masks travel (slice.h). A slice that
/// is lost leaves its tiles unknown and nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "stereo/frame/known_tiles.h"
#include "stereo/frame/pixel_plane.h"
#include "stereo/wire/messages.h"
#include "stereo/wire/tile_blocks.h"

namespace farshade {

/// Packs plane after plane; keeps its buffers, so that packing allocates nothing once warm.
///
///     packer.start(frame, eye, kind, plane);
///     while (const std::optional<PlaneSlice> slice = packer.next()) send(*slice);
class PlanePacker {
 public:
  /// Packs `plane`, which must stay as it is until the last slice was made.
  void start(FrameId frame, Side eye, PlaneKind kind, const PixelPlane& plane);

  /// The next slice, or none after the last. Its block lives here, until the next call.
  [[nodiscard]] std::optional<PlaneSlice> next();

 private:
  const PixelPlane* plane_ = nullptr;
  PlaneSlice slice_;  ///< what all slices of this plane share, and where the next one starts
  TileBlocks ready_;  ///< tiles from slice_.first_tile on
  std::array<std::byte, kMaxPlaneBlock_bytes> block_;
};

/// Writes the tiles of a slice, as decode_client or decode_server gave it, into `plane` and sets them in
/// `known` (one entry a tile of the plane) to 1. Returns how many of them were 0 before: 0 for a duplicate,
/// TileGrid::count() over all slices of a plane. Refuses a slice for a plane of another size or word length,
/// and every block that is not exactly the tiles it claims. Then plane and known stay as they were.
[[nodiscard]] Decoded<std::uint32_t> decode_plane_tiles(const PlaneSlice& slice, PixelPlane& plane,
                                                        KnownTiles& known);

}  // namespace farshade
