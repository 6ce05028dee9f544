/// Slices: the tiles of a mask, packed into datagrams that each decode alone.
///
/// Tiles are written one after the other (tile_codec.h); each datagram takes as many whole ones as it holds
/// (tile_blocks.h). A datagram that is lost leaves its tiles unknown and nothing else.
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

/// How a light that is the same all over a tile is told.
enum class SameAllOver : std::uint8_t {
  OneValue,   ///< once for the tile
  EachPixel,  ///< as any other: what it costs where the plan leaves nothing out
};

/// Packs eye after eye; keeps its buffers, so that packing allocates nothing once warm.
///
///     packer.start(frame, eye);
///     while (const std::optional<Slice> slice = packer.next()) send(*slice);
class SlicePacker {
 public:
  explicit SlicePacker(SameAllOver same = SameAllOver::OneValue) : same_(same) {}

  /// Packs `eye` of `frame`, which must stay as it is until the last slice was made. `sent` has one entry a
  /// tile, 0 = not to be sent; empty: all are sent.
  void start(const ShadowFrame& frame, Side eye, std::span<const std::uint8_t> sent = {});

  /// The next slice, or none after the last. Its block lives here, until the next call.
  [[nodiscard]] std::optional<Slice> next();

 private:
  void write_ahead();
  void write(std::uint32_t tile, const TileGrid& grid, std::uint32_t lights,
             std::vector<std::byte>& bytes) const;

  SameAllOver same_;
  const EyeMask* mask_ = nullptr;
  std::span<const std::uint8_t> sent_;
  Slice slice_;       ///< what all slices of this eye share, and where the next one starts
  TileBlocks ready_;  ///< tiles from slice_.first_tile on
  std::array<std::byte, kMaxBlock_bytes> block_;
};

/// Writes the tiles of a slice, as decode_server gave it, into `mask` and marks them in `known` (one entry a
/// tile of the mask). Returns how many of them were unknown before, planes counted one by one: 0 for a
/// duplicate, TileGrid::count() x planes() over all slices of a mask. Refuses a slice for a mask of another
/// size or light count, and every block that is not exactly the tiles it claims. Then, and for tiles not
/// sent, mask and known stay as they were.
[[nodiscard]] Decoded<std::uint32_t> decode_slice_tiles(const Slice& slice, EyeMask& mask, KnownTiles& known);

}  // namespace farshade
