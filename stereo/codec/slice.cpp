#include "stereo/codec/slice.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {
namespace {

constexpr std::uint32_t kMostSliceTiles = 0xffff;  // what the field of the message can hold

/// The first decision of a slice: it has one tile, in plain bits. It costs at most 9 bits. With the tile's
/// lights and the last byte, any tile fits.
constexpr std::size_t kPlainTile_bytes = 32 * 256 / 8;
static_assert(kPlainTile_bytes + 4 <= kBaseMessage_bytes - kSliceHeader_bytes,
              "any tile fits, even if nothing in it can be guessed");

}  // namespace

RequestedTiles::RequestedTiles(Extent size, std::uint32_t lights, std::span<const RequestedTile> requested)
    : grid_{size},
      every_(all_lights_in(kAllBlocks, lights)),
      requested_(requested),
      columns_(grid_.columns()),
      last_row_(grid_.count() - std::min(grid_.count(), columns_)) {
  check(requested.empty() || requested.size() == grid_.count(),
        "each tile has requested blocks, or all are asked for");
}

RequestedTile RequestedTiles::at(std::uint32_t tile) const {
  const bool is_inside = tile % columns_ + 1 < columns_ && tile < last_row_;
  if (is_inside && requested_.empty()) return every_;
  RequestedTile requested = requested_.empty() ? every_ : requested_[tile];
  const BlockBits inside = is_inside ? kAllBlocks : blocks_in(grid_.rect(tile));
  for (std::uint32_t share = 0; share < kMostShares; ++share)
    requested.shares[share] &= static_cast<BlockBits>(every_.shares[share] & inside);
  return requested;
}

std::uint32_t RequestedTiles::count() const {
  std::uint32_t tiles = 0;
  for (std::uint32_t tile = 0; tile < grid_.count(); ++tile) tiles += at(tile).any() != kNoBlocks;
  return tiles;
}

void SlicePacker::start(const ShadowFrame& frame, Side eye, std::span<const RequestedTile> requested,
                        std::span<const std::uint8_t> sent, std::size_t most_bytes) {
  mask_ = &frame.masks[index_of(eye)];
  requested_ = requested;
  sent_ = sent;
  slice_ = {.frame = frame.frame,
            .light_set_revision = frame.light_set_revision,
            .eye = eye,
            .size = mask_->size(),
            .lights = mask_->lights()};
  check(most_bytes >= kBaseMessage_bytes && most_bytes <= kMaxMessage_bytes, "a path carries such messages");
  most_block_bytes_ = most_bytes - kSliceHeader_bytes;
  check(sent.empty() || sent.size() == TileGrid{slice_.size}.count(), "each tile is sent or not");
}

std::optional<Slice> SlicePacker::next() {
  check(mask_ != nullptr, "packing was started");
  const std::uint32_t tiles = TileGrid{slice_.size}.count();
  find_requested_tile();
  if (slice_.first_tile == tiles) {
    if (slice_.plane + 1 >= mask_->layout().planes()) return std::nullopt;
    ++slice_.plane;
    slice_.first_tile = 0;
    find_requested_tile();
    if (slice_.first_tile == tiles) return std::nullopt;
  }
  pack_tiles();
  if (slice_.tile_count == 0) pack_plain();
  Slice made = slice_;
  made.block = block_;
  slice_.first_tile += slice_.tile_count;
  return made;
}

/// Goes to the first tile of the next slice.
void SlicePacker::find_requested_tile() {
  const RequestedTiles requested(slice_.size, slice_.lights, requested_);
  const std::uint32_t tiles = TileGrid{slice_.size}.count();
  while (slice_.first_tile < tiles &&
         (requested.at(slice_.first_tile).any() == kNoBlocks || !is_sent(slice_.first_tile)))
    ++slice_.first_tile;
}

bool SlicePacker::is_sent(std::uint32_t tile) const {
  return sent_.empty() || sent_[tile] != 0;
}

/// Reads a tile from the mask.
void SlicePacker::read(std::uint32_t tile, const RequestedTile& requested) {
  split_tile(*mask_, TileGrid{slice_.size}.rect(tile), slice_.plane, requested, bits_);
}

/// Codes as many tiles as fit, which may be none.
void SlicePacker::pack_tiles() {
  const TileGrid grid{slice_.size};
  const RequestedTiles requested(slice_.size, slice_.lights, requested_);
  MaskModels models(kInitialMaskModels);
  coded_.start(grid.columns(), slice_.first_tile);
  RangeEncoder encoder(block_);
  MaskCoder coder(encoder, models, coded_, mask_->layout().lights_in(slice_.plane));
  coder.form(false);
  slice_.tile_count = 0;
  RangeEncoder::Mark fits = encoder.mark();
  const std::uint32_t end = std::min(grid.count(), slice_.first_tile + kMostSliceTiles);
  for (std::uint32_t tile = slice_.first_tile; tile < end; ++tile) {
    if (!is_sent(tile)) break;
    const RequestedTile in_tile = requested.at(tile);
    if (in_tile.any() == kNoBlocks) {
      coded_.add_nothing();
      continue;
    }
    read(tile, in_tile);
    coder.tile(in_tile, bits_);
    if (encoder.size_bytes() > most_block_bytes_) break;
    fits = encoder.mark();
    slice_.tile_count = tile - slice_.first_tile + 1;
  }
  encoder.rewind(fits);
  encoder.finish();
}

/// Codes one tile in plain bits.
void SlicePacker::pack_plain() {
  const RequestedTile requested =
      RequestedTiles(slice_.size, slice_.lights, requested_).at(slice_.first_tile);
  MaskModels models(kInitialMaskModels);
  coded_.start(TileGrid{slice_.size}.columns(), slice_.first_tile);
  RangeEncoder encoder(block_);
  MaskCoder coder(encoder, models, coded_, mask_->layout().lights_in(slice_.plane));
  coder.form(true);
  read(slice_.first_tile, requested);
  for (std::uint32_t light = 0; light < 32; ++light)
    if ((bits_.varies >> light & 1) == 0) bits_.cells[light].fill(cell_of((bits_.value >> light & 1) != 0));
  coder.plain_tile(requested, bits_);
  encoder.finish();
  slice_.tile_count = 1;
}

namespace {

/// Decodes the tiles of a slice into `coded`. Returns false if the block does not end with them.
bool decode(const Slice& slice, const RequestedTiles& requested, std::uint32_t lights, TileBits& bits,
            CodedTiles& coded) {
  RangeDecoder decoder(slice.block);
  MaskModels models(kInitialMaskModels);
  coded.start(TileGrid{slice.size}.columns(), slice.first_tile);
  MaskCoder coder(decoder, models, coded, lights);
  const bool plain = coder.form(false);
  if (plain && slice.tile_count != 1) return false;
  for (std::uint32_t tile = slice.first_tile; tile < slice.first_tile + slice.tile_count; ++tile) {
    const RequestedTile in_tile = requested.at(tile);
    if (in_tile.any() == kNoBlocks)
      coded.add_nothing();
    else if (plain)
      coder.plain_tile(in_tile, bits);
    else
      coder.tile(in_tile, bits);
    if (decoder.has_failed()) return false;
  }
  return decoder.is_at_end();
}

}  // namespace

Decoded<std::uint32_t> decode_slice_tiles(const Slice& slice, std::span<const RequestedTile> requested,
                                          EyeMask& mask, ReceivedTiles& known) {
  if (slice.size != mask.size() || slice.lights != mask.lights()) return refuse(WireRefusal::OtherMask);
  const TileGrid grid{slice.size};
  const MaskLayout layout = mask.layout();
  check(slice.plane < layout.planes() && slice.first_tile + slice.tile_count <= grid.count(),
        "a slice is within its mask");
  check(known.size() == grid.count(), "received tiles are those of the mask");
  const auto plane_bit = static_cast<std::uint8_t>(1u << slice.plane);
  if (is_any_received(known, slice.first_tile, slice.tile_count, plane_bit)) return 0u;

  TileBits bits;
  CodedTiles coded;
  if (!decode(slice, RequestedTiles(slice.size, slice.lights, requested), layout.lights_in(slice.plane), bits,
              coded))
    return refuse(WireRefusal::Block);

  std::uint32_t learned = 0, tile = slice.first_tile;
  for (const CodedTile& one : coded.tiles()) {
    if (one.requested.any() != kNoBlocks) {
      coded.read(one, bits);
      merge_tile(bits, grid.rect(tile), slice.plane, one.requested, mask);
      ++learned;
      known[tile] |= plane_bit;
    }
    ++tile;
  }
  return learned;
}

}  // namespace farshade
