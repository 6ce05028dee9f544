/// Slices: packs the tiles of a mask into messages that decode independently.
///
/// What is asked for of the tiles is coded one tile after the other (mask_coder.h). Each slice takes as many
/// whole tiles as fit into its datagram. If a datagram is lost, only its tiles stay unknown.
///
/// In each plane, the slices have every tile that something is asked for of. If that is no light of the
/// plane, the tile costs no decision there. So a tile is known when all of its planes are, whatever lights
/// were asked for.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/codec/mask_coder.h"
#include "stereo/frame/received_tiles.h"
#include "stereo/frame/requested_blocks.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/tiles.h"
#include "stereo/messages/messages.h"

namespace farshade {

/// The tiles of one eye that a slice can contain: both sides know which blocks were asked for.
class RequestedTiles {
 public:
  /// `requested` has one entry for each tile. If it is empty, all blocks are asked for in all lights.
  RequestedTiles(Extent size, std::uint32_t lights, std::span<const RequestedTile> requested);

  /// What is asked for of a tile and lies inside the picture.
  [[nodiscard]] RequestedTile at(std::uint32_t tile) const;
  /// Number of tiles with a requested block.
  [[nodiscard]] std::uint32_t count() const;

 private:
  TileGrid grid_;
  RequestedTile every_;  ///< all blocks in all lights
  std::span<const RequestedTile> requested_;
  std::uint32_t columns_, last_row_;  ///< tiles before them are wholly inside the picture
};

/// Packs one eye after another. It reuses its buffers, so that it allocates only for the first masks.
///
///     packer.start(frame, eye);
///     while (const std::optional<Slice> slice = packer.next()) send(*slice);
class SlicePacker {
 public:
  /// Starts to pack `eye` of `frame`, which must stay unchanged until the last slice, and so must `requested`
  /// and `sent`. They have one entry for each tile. `requested`: what is asked for; everything if it is
  /// empty. `sent`: 0: the tile is in no slice, since it is not known here what is asked for of it; if it is
  /// empty, all tiles are sent. A slice's message has at most `most_bytes`, which are kBaseMessage_bytes to
  /// kMaxMessage_bytes.
  void start(const ShadowFrame& frame, Side eye, std::span<const RequestedTile> requested = {},
             std::span<const std::uint8_t> sent = {}, std::size_t most_bytes = kBaseMessage_bytes);

  /// Returns the next slice, or nothing after the last. Its block is valid until the next call.
  [[nodiscard]] std::optional<Slice> next();

 private:
  void find_requested_tile();
  void pack_tiles();
  void pack_plain();
  [[nodiscard]] bool is_sent(std::uint32_t tile) const;
  void read(std::uint32_t tile, const RequestedTile& requested);

  const EyeMask* mask_ = nullptr;
  std::span<const RequestedTile> requested_;
  std::span<const std::uint8_t> sent_;
  std::size_t most_block_bytes_ = 0;
  Slice slice_;  ///< fields that all slices of this eye share, and the next slice's first tile
  std::vector<std::byte> block_;
  CodedTiles coded_;
  TileBits bits_;
};

/// Writes what was asked for of a decoded slice's tiles into `mask` and marks the tiles in `known` (one entry
/// for each tile of the mask). `requested` is that of the request, one entry for each tile, or none if
/// everything is asked for. Returns the number of these tiles; 0 for a duplicate, which is a slice with a
/// tile that is known in its plane: it is not decoded and changes nothing. Refuses a slice of a mask with
/// another size or light count, and a block that does not end with the slice's tiles; damage that turns it
/// into the block of other tiles is not noticed here. After a refusal, mask and known are unchanged.
[[nodiscard]] Decoded<std::uint32_t> decode_slice_tiles(const Slice& slice,
                                                        std::span<const RequestedTile> requested,
                                                        EyeMask& mask, ReceivedTiles& known);

}  // namespace farshade
