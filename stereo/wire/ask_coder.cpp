#include "stereo/wire/ask_coder.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/wire/decision_counts.h"

namespace farshade {
namespace {

constexpr std::uint32_t kMostAskTiles = 0xffff;  // what the field of the message can hold

}  // namespace

template <class Io>
const AskedTile* AskCoder<Io>::near(std::uint32_t tile, int dx, int dy) const {
  const auto columns = static_cast<std::int64_t>(columns_);
  const std::int64_t column = tile % columns_ + std::int64_t{dx};
  const std::int64_t at = static_cast<std::int64_t>(coded_.size()) + dy * columns + dx;
  if (column < 0 || column >= columns || at < 0) return nullptr;
  return &coded_[static_cast<std::size_t>(at)];
}

template <class Io>
void AskCoder<Io>::tile(std::uint32_t tile, AskedTile& asked) {
  const AskedTile *west = near(tile, -1, 0), *north = near(tile, 0, -1);
  const AskedTile *north_west = near(tile, -1, -1), *north_east = near(tile, 1, -1);
  for (std::uint32_t share = 0; share < shares_; ++share) {
    const auto of = [share](const AskedTile* near_tile) {
      return near_tile == nullptr ? kUnknownCell : Neighbour{near_tile->shares[share]};
    };
    cell({.west = of(west), .north = of(north), .north_west = of(north_west), .north_east = of(north_east)},
         asked.shares[share]);
  }
  coded_.push_back(asked);
}

template <class Io>
void AskCoder<Io>::cell(const Neighbours& around, Cell& cell) {
  const Touch west = touch(around.west, kLastColumn), north = touch(around.north, kLastRow);
  const std::uint32_t north_west = three_of(touch(around.north_west, kLowerRight));
  const std::uint32_t north_east = three_of(touch(around.north_east, kLowerLeft));
  const std::size_t context = ((west * 4u + north) * 3 + north_west) * 3 + north_east;
  if (!code(kAnyModels + context, cell != kEmptyCell))
    cell = kEmptyCell;
  else if (code(kEveryModels + west * 4u + north, cell == kFullCell))
    cell = kFullCell;
  else
    cell = mixed(around, cell);
}

template <class Io>
Cell AskCoder<Io>::mixed(const Neighbours& around, Cell cell) {
  Border border(around);
  std::uint32_t coded = 0;
  for (std::uint32_t y = 0; y < 4; ++y) {
    std::uint32_t row = border.left_of(y);
    for (std::uint32_t x = 0; x < 4; ++x) {
      const std::uint32_t at = 4 * y + x;
      // The last bit makes the bits differ if no other does.
      bool bit = coded == 0;
      if (at < 15 || (coded != 0 && coded != 0x7fff)) {
        const std::uint32_t wide = (border.above >> x & 1) | (border.above >> (x + 4) & 1) << 1;
        bit = code(kBlockModels + wide * kBitContexts + bit_context(row, border, x), (cell >> at & 1) != 0);
      }
      row |= (bit ? 4u : 0u) << x;
      coded |= (bit ? 1u : 0u) << at;
    }
    border.below(row);
  }
  return static_cast<Cell>(coded);
}

template class AskCoder<RangeEncoder>;
template class AskCoder<RangeDecoder>;
template class AskCoder<DecisionCounts>;

void AskPacker::start(FrameId frame, Side eye, Extent size, std::uint32_t lights,
                      std::span<const AskedTile> asked) {
  check_eq(asked.size(), std::size_t{TileGrid{size}.count()}, "each tile has its asked blocks");
  asked_ = asked;
  slice_ = {.frame = frame, .eye = eye, .size = size, .lights = lights};
}

std::optional<AskSlice> AskPacker::next() {
  const TileGrid grid{slice_.size};
  if (slice_.first_tile == grid.count()) return std::nullopt;
  AskModels models(kInitialAskModels);
  RangeEncoder encoder(block_);
  AskCoder coder(encoder, models, grid.columns(), slice_.lights);
  RangeEncoder::Mark fits = encoder.mark();
  const std::uint32_t end = std::min(grid.count(), slice_.first_tile + kMostAskTiles);
  std::uint32_t tile = slice_.first_tile;
  for (; tile < end; ++tile) {
    AskedTile asked = asked_[tile];
    coder.tile(tile, asked);
    if (encoder.size_bytes() > kMaxAskBlock_bytes) break;
    fits = encoder.mark();
  }
  // A share of a tile has at most 18 decisions of at most 9 bits.
  static_assert(kMostShares * 18 * 9 / 8 + 2 <= kMaxAskBlock_bytes, "any tile fits");
  encoder.rewind(fits);
  AskSlice made = slice_;
  made.tile_count = tile - slice_.first_tile;
  encoder.finish();
  made.block = block_;
  slice_.first_tile = tile;
  return made;
}

Decoded<std::uint32_t> decode_ask_slice(const AskSlice& slice, std::vector<AskedTile>& asked,
                                        KnownTiles& known) {
  const TileGrid grid{slice.size};
  if (asked.size() != grid.count()) return refuse(WireRefusal::OtherMask);
  check_eq(known.size(), asked.size(), "an entry for each tile");
  check(slice.first_tile + slice.tile_count <= grid.count(), "a slice is within its grid");
  RangeDecoder decoder(slice.block);
  AskModels models(kInitialAskModels);
  AskCoder coder(decoder, models, grid.columns(), slice.lights);
  std::vector<AskedTile> decoded(slice.tile_count);
  for (std::uint32_t i = 0; i < slice.tile_count && !decoder.has_failed(); ++i)
    coder.tile(slice.first_tile + i, decoded[i]);
  if (!decoder.is_at_end()) return refuse(WireRefusal::Block);
  std::uint32_t learned = 0;
  for (std::uint32_t i = 0; i < slice.tile_count; ++i) {
    asked[slice.first_tile + i] = decoded[i];
    learned += known[slice.first_tile + i] == 0;
    known[slice.first_tile + i] = 1;
  }
  return learned;
}

}  // namespace farshade
