#include "stereo/wire/slice.h"

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/tile_codec.h"

namespace farshade {

static_assert(most_packed_bytes(kMaxTile_bytes) <= kMaxBlock_bytes,
              "any tile fits, even if LZ4 gains nothing");

void SlicePacker::start(const ShadowFrame& frame, Side eye, std::span<const std::uint8_t> sent) {
  mask_ = &frame.masks[index_of(eye)];
  sent_ = sent;
  slice_ = {.frame = frame.frame,
            .light_set_revision = frame.light_set_revision,
            .eye = eye,
            .size = mask_->size(),
            .lights = mask_->lights()};
  ready_.clear();
  check(sent.empty() || sent.size() == TileGrid{slice_.size}.count(), "each tile is sent or not");
}

std::optional<Slice> SlicePacker::next() {
  check(mask_ != nullptr, "packing was started");
  const std::uint32_t tiles = TileGrid{slice_.size}.count();
  if (slice_.first_tile == tiles) {
    if (slice_.plane + 1 >= mask_->layout().planes()) return std::nullopt;
    ++slice_.plane;
    slice_.first_tile = 0;
  }
  write_ahead();
  const TileBlocks::Packed packed = ready_.pack(block_);
  Slice made = slice_;
  made.tile_count = packed.tiles;
  made.block = std::span(block_).first(packed.block_bytes);
  slice_.first_tile += packed.tiles;
  return made;
}

/// Codes tiles until there are enough for a slice, or the plane ends.
void SlicePacker::write_ahead() {
  const TileGrid grid{slice_.size};
  const std::uint32_t lights = mask_->layout().lights_in(slice_.plane);
  for (std::uint32_t tile = slice_.first_tile + ready_.ready();
       tile < grid.count() && ready_.has_room_for(kMaxTile_bytes); ++tile)
    ready_.add([&](std::vector<std::byte>& bytes) { write(tile, grid, lights, bytes); });
}

void SlicePacker::write(std::uint32_t tile, const TileGrid& grid, std::uint32_t lights,
                        std::vector<std::byte>& bytes) const {
  if (!sent_.empty() && sent_[tile] == 0) return write_not_sent(bytes);
  TileBits bits = split_tile(*mask_, grid.rect(tile), slice_.plane);
  if (same_ == SameAllOver::EachPixel) spell_out(lights, bits);
  write_tile(bits, lights, bytes);
}

Decoded<std::uint32_t> decode_slice_tiles(const Slice& slice, EyeMask& mask, KnownTiles& known) {
  if (slice.size != mask.size() || slice.lights != mask.lights()) return refuse(WireRefusal::OtherMask);
  const TileGrid grid{slice.size};
  const MaskLayout layout = mask.layout();
  check(slice.plane < layout.planes() && slice.first_tile + slice.tile_count <= grid.count(),
        "a slice is within its mask");
  check(known.size() == grid.count(), "known tiles are those of the mask");

  OpenedBlock opened;
  const std::optional<std::span<const std::byte>> tiles = open_block(slice.block, opened);
  if (!tiles) return refuse(WireRefusal::Block);

  // Checks all tiles first, so that nothing is written from a damaged slice.
  const std::uint32_t lights = layout.lights_in(slice.plane);
  TileBits bits;
  ByteReader checked(*tiles);
  for (std::uint32_t i = 0; i < slice.tile_count; ++i)
    if (const Decoded<TileCoding> coding = read_tile(checked, lights, bits); !coding)
      return refuse(coding.error());
  if (checked.remaining() > 0) return refuse(WireRefusal::TileLength);

  ByteReader in(*tiles);
  std::uint32_t learned = 0;
  for (std::uint32_t tile = slice.first_tile; tile < slice.first_tile + slice.tile_count; ++tile) {
    if (*read_tile(in, lights, bits) == TileCoding::NotSent) continue;
    merge_tile(bits, grid.rect(tile), slice.plane, mask);
    const auto plane_bit = static_cast<std::uint8_t>(1u << slice.plane);
    learned += (known[tile] & plane_bit) == 0;
    known[tile] |= plane_bit;
  }
  return learned;
}

}  // namespace farshade
