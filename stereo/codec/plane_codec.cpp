#include "stereo/codec/plane_codec.h"

#include "stereo/base/check.h"
#include "stereo/codec/plane_tile.h"
#include "stereo/frame/tiles.h"

namespace farshade {

static_assert(most_packed_bytes(kMaxPlaneTile_bytes) <= kBaseMessage_bytes - kPlaneSliceHeader_bytes,
              "any tile fits, even if LZ4 gains nothing");

void PlanePacker::start(FrameId frame, Side eye, PlaneKind kind, const PixelPlane& plane,
                        std::size_t most_bytes) {
  check(plane.word_bytes >= 1 && plane.word_bytes <= kMaxPlaneWord_bytes, "a word has 1 to 4 bytes");
  check_eq(plane.words.size(), plane.size.pixels(), "a word for each pixel");
  check(most_bytes >= kBaseMessage_bytes && most_bytes <= kMaxMessage_bytes, "a path carries such messages");
  most_block_bytes_ = most_bytes - kPlaneSliceHeader_bytes;
  plane_ = &plane;
  slice_ = {.frame = frame, .eye = eye, .kind = kind, .size = plane.size, .word_bytes = plane.word_bytes};
  ready_.clear();
}

std::optional<PlaneSlice> PlanePacker::next() {
  check(plane_ != nullptr, "packing was started");
  const TileGrid grid{slice_.size};
  if (slice_.first_tile == grid.count()) return std::nullopt;
  const PlaneLanes lanes = lanes_of(slice_.kind, slice_.word_bytes);
  for (std::uint32_t tile = slice_.first_tile + ready_.ready();
       tile < grid.count() && ready_.has_room_for(kMaxPlaneTile_bytes); ++tile)
    ready_.add([&](std::vector<std::byte>& bytes) {
      TileWords words;
      load_tile(*plane_, grid.rect(tile), words);
      write_plane_tile(words, lanes, bytes);
    });
  const TileBlocks::Packed packed = ready_.pack(std::span(block_).first(most_block_bytes_));
  PlaneSlice made = slice_;
  made.tile_count = packed.tiles;
  made.block = std::span(block_).first(packed.block_bytes);
  slice_.first_tile += packed.tiles;
  return made;
}

Decoded<std::uint32_t> decode_plane_tiles(const PlaneSlice& slice, PixelPlane& plane, ReceivedTiles& known) {
  if (slice.size != plane.size || slice.word_bytes != plane.word_bytes) return refuse(WireRefusal::OtherMask);
  const TileGrid grid{slice.size};
  check(slice.first_tile + slice.tile_count <= grid.count(), "a slice is within its plane");
  check_eq(plane.words.size(), plane.size.pixels(), "a word for each pixel");
  check_eq(known.size(), std::size_t{grid.count()}, "received tiles are those of the plane");
  if (is_any_received(known, slice.first_tile, slice.tile_count, 1)) return 0u;

  OpenedBlock opened;
  const std::optional<std::span<const std::byte>> tiles = open_block(slice.block, opened);
  if (!tiles) return refuse(WireRefusal::Block);

  // Checks all tiles first, so that nothing is written from a damaged slice.
  const PlaneLanes lanes = lanes_of(slice.kind, slice.word_bytes);
  ByteReader checked(*tiles);
  for (std::uint32_t i = 0; i < slice.tile_count; ++i)
    if (const Decoded<void> tile = skip_plane_tile(checked, lanes); !tile) return refuse(tile.error());
  if (checked.remaining() > 0) return refuse(WireRefusal::TileLength);

  ByteReader in(*tiles);
  TileWords words;
  for (std::uint32_t tile = slice.first_tile; tile < slice.first_tile + slice.tile_count; ++tile) {
    check(read_plane_tile(in, lanes, words).has_value(), "a checked tile is complete");
    store_tile(words, grid.rect(tile), plane);
    known[tile] = 1;
  }
  return slice.tile_count;
}

}  // namespace farshade
