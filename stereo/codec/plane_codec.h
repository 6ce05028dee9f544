/// Plane codec: packs a plane of pixels into slices that decode independently, like a mask (slice.h). If a
/// slice is lost, only its tiles stay unknown.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "stereo/codec/tile_blocks.h"
#include "stereo/frame/pixel_plane.h"
#include "stereo/frame/received_tiles.h"
#include "stereo/messages/messages.h"

namespace farshade {

/// Packs one plane after another. It reuses its buffers, so that it allocates only for the first planes.
///
///     packer.start(frame, eye, kind, plane);
///     while (const std::optional<PlaneSlice> slice = packer.next()) send(*slice);
class PlanePacker {
 public:
  /// Starts to pack `plane`, which must stay unchanged until the last slice. A slice's message has at most
  /// `most_bytes`, which are kBaseMessage_bytes to kMaxMessage_bytes.
  void start(FrameId frame, Side eye, PlaneKind kind, const PixelPlane& plane,
             std::size_t most_bytes = kBaseMessage_bytes);

  /// Returns the next slice, or nothing after the last. Its block is valid until the next call.
  [[nodiscard]] std::optional<PlaneSlice> next();

 private:
  const PixelPlane* plane_ = nullptr;
  PlaneSlice slice_;  ///< fields that all slices of this plane share, and the next slice's first tile
  TileBlocks ready_;  ///< written tiles, from slice_.first_tile on
  std::size_t most_block_bytes_ = 0;
  std::array<std::byte, kMaxPlaneBlock_bytes> block_;
};

/// Writes the tiles of a decoded slice into `plane` and sets their entries in `known` (one for each tile of
/// the plane) to 1. Returns the number of these tiles; 0 for a duplicate, which is a slice with a received
/// tile: it is not decoded and changes nothing. Refuses a slice of a plane with another size or word length,
/// and a block whose content is not exactly the slice's tiles. After a refusal plane and known are unchanged.
[[nodiscard]] Decoded<std::uint32_t> decode_plane_tiles(const PlaneSlice& slice, PixelPlane& plane,
                                                        ReceivedTiles& known);

}  // namespace farshade
