#include "stereo/wire/slice.h"

#include <lz4.h>

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/tile_codec.h"

namespace farshade {
namespace {

static_assert(kMaxTile_bytes + kMaxTile_bytes / 255 + 16 <= kMaxBlock_bytes,
              "any tile fits, even if LZ4 gains nothing");

const char* chars(const std::byte* bytes) {
  return reinterpret_cast<const char*>(bytes);
}
char* chars(std::byte* bytes) {
  return reinterpret_cast<char*>(bytes);
}

}  // namespace

void SlicePacker::start(const ShadowFrame& frame, Side eye, std::span<const std::uint8_t> sent) {
  mask_ = &frame.masks[index_of(eye)];
  sent_ = sent;
  slice_ = {.frame = frame.frame,
            .light_set_revision = frame.light_set_revision,
            .eye = eye,
            .size = mask_->size(),
            .lights = mask_->lights()};
  written_.clear();
  tile_ends_.clear();
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
  const Fit fit = compress();
  Slice made = slice_;
  made.tile_count = fit.tiles;
  made.block = std::span(block_).first(fit.block_bytes);

  const std::size_t packed_bytes = written_bytes(fit.tiles);
  written_.erase(written_.begin(), written_.begin() + static_cast<std::ptrdiff_t>(packed_bytes));
  tile_ends_.erase(tile_ends_.begin(), tile_ends_.begin() + fit.tiles);
  for (std::size_t& end : tile_ends_) end -= packed_bytes;
  slice_.first_tile += fit.tiles;
  return made;
}

/// Writes tiles until a slice's worth lies ready, or the plane ends.
void SlicePacker::write_ahead() {
  const TileGrid grid{slice_.size};
  const std::uint32_t lights = mask_->layout().lights_in(slice_.plane);
  auto tile = slice_.first_tile + static_cast<std::uint32_t>(tile_ends_.size());
  for (; tile < grid.count() && written_.size() + kMaxTile_bytes <= kMaxSliceOpened_bytes; ++tile) {
    if (!sent_.empty() && sent_[tile] == 0) {
      write_not_sent(written_);
    } else {
      TileBits bits = split_tile(*mask_, grid.rect(tile), slice_.plane);
      if (same_ == SameAllOver::EachPixel) spell_out(lights, bits);
      write_tile(bits, lights, written_);
    }
    tile_ends_.push_back(written_.size());
  }
}

/// LZ4 tells how many bytes it could fit; the tile that they end in is left for the next slice. What is
/// before it is compressed again, alone, and hardly ever grows by that; if it does, one more tile is left.
SlicePacker::Fit SlicePacker::compress() {
  int taken = static_cast<int>(written_.size());
  const int filled = LZ4_compress_destSize(chars(written_.data()), chars(block_.data()), &taken,
                                           static_cast<int>(block_.size()));
  const auto end = std::upper_bound(tile_ends_.begin(), tile_ends_.end(), static_cast<std::size_t>(taken));
  auto tiles = static_cast<std::uint32_t>(end - tile_ends_.begin());
  if (tiles > 0 && written_bytes(tiles) == static_cast<std::size_t>(taken))
    return {tiles, static_cast<std::size_t>(filled)};
  for (tiles = std::max(tiles, 1u); tiles > 0; --tiles) {
    const int size =
        LZ4_compress_default(chars(written_.data()), chars(block_.data()),
                             static_cast<int>(written_bytes(tiles)), static_cast<int>(block_.size()));
    if (size > 0) return {tiles, static_cast<std::size_t>(size)};
  }
  check(false, "one tile fits into a slice");
  return {};
}

Decoded<std::uint32_t> decode_slice_tiles(const Slice& slice, EyeMask& mask, KnownTiles& known) {
  if (slice.size != mask.size() || slice.lights != mask.lights()) return refuse(WireRefusal::OtherMask);
  const TileGrid grid{slice.size};
  const MaskLayout layout = mask.layout();
  check(slice.plane < layout.planes() && slice.first_tile + slice.tile_count <= grid.count(),
        "a slice is within its mask");
  check(known.size() == grid.count(), "known tiles are those of the mask");

  std::array<std::byte, kMaxSliceOpened_bytes> opened;
  const int size = LZ4_decompress_safe(chars(slice.block.data()), chars(opened.data()),
                                       static_cast<int>(slice.block.size()), static_cast<int>(opened.size()));
  if (size < 0) return refuse(WireRefusal::Block);
  const std::span<const std::byte> tiles = std::span(opened).first(static_cast<std::size_t>(size));

  // Once to look, once to write: nothing is written from a slice that turns out to be broken further on.
  const std::uint32_t lights = layout.lights_in(slice.plane);
  TileBits bits;
  ByteReader looked(tiles);
  for (std::uint32_t i = 0; i < slice.tile_count; ++i)
    if (const Decoded<TileCoding> coding = read_tile(looked, lights, bits); !coding)
      return refuse(coding.error());
  if (looked.remaining() > 0) return refuse(WireRefusal::TileLength);

  ByteReader in(tiles);
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

std::string lz4_version() {
  return LZ4_versionString();
}

}  // namespace farshade
