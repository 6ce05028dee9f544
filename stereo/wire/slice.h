/// Slices: packs the tiles of a mask into messages that decode independently.
///
/// Tiles are coded one after the other (tile_codec.h). Each slice takes as many whole tiles as fit into its
/// datagram (tile_blocks.h). If a datagram is lost, only its tiles stay unknown.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/frame/known_tiles.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/messages.h"
#include "stereo/wire/tile_blocks.h"

namespace farshade {

/// How a light that has the same value in all pixels of a tile is coded.
enum class SameAllOver : std::uint8_t {
  OneValue,   ///< one bit for the tile
  EachPixel,  ///< one bit for each pixel, to measure the cost of a plan without savings
};

/// Packs one eye after another. It reuses its buffers, so that it allocates only for the first masks.
///
///     packer.start(frame, eye);
///     while (const std::optional<Slice> slice = packer.next()) send(*slice);
class SlicePacker {
 public:
  explicit SlicePacker(SameAllOver same = SameAllOver::OneValue) : same_(same) {}

  /// Starts to pack `eye` of `frame`, which must stay unchanged until the last slice. `sent` has one entry
  /// for each tile, 0: the tile is not sent. If `sent` is empty, all tiles are sent.
  void start(const ShadowFrame& frame, Side eye, std::span<const std::uint8_t> sent = {});

  /// Returns the next slice, or nothing after the last. Its block is valid until the next call.
  [[nodiscard]] std::optional<Slice> next();

 private:
  void write_ahead();
  void write(std::uint32_t tile, const TileGrid& grid, std::uint32_t lights,
             std::vector<std::byte>& bytes) const;

  SameAllOver same_;
  const EyeMask* mask_ = nullptr;
  std::span<const std::uint8_t> sent_;
  Slice slice_;       ///< fields that all slices of this eye share, and the next slice's first tile
  TileBlocks ready_;  ///< written tiles, from slice_.first_tile on
  std::array<std::byte, kMaxBlock_bytes> block_;
};

/// Writes the tiles of a decoded slice into `mask` and marks them in `known` (one entry for each tile of the
/// mask). Returns how many of these tiles were unknown in the slice's plane before: 0 for a duplicate.
/// Refuses a slice of a mask with another size or light count, and a block whose content is not exactly the
/// slice's tiles. After a refusal, and for tiles that were not sent, mask and known are unchanged.
[[nodiscard]] Decoded<std::uint32_t> decode_slice_tiles(const Slice& slice, EyeMask& mask, KnownTiles& known);

}  // namespace farshade
