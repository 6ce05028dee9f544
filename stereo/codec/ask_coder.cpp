#include "stereo/codec/ask_coder.h"

#include <algorithm>
#include <bit>

#include "stereo/base/check.h"
#include "stereo/codec/decision_counts.h"

namespace farshade {
namespace {

constexpr std::uint32_t kMostAskTiles = 0xffff;  // what the field of the message can hold

/// The shares of the blocks around a block.
struct SharesAround {
  BlockShares west, north, north_west, north_east;
};

/// Codes the shares of blocks that are asked for. It has a copy of the coder.
template <class Io>
class ShareCoder {
 public:
  ShareCoder(const Io& io, AskModels& models, std::uint32_t shares)
      : io_(io), models_(models), shares_(shares), every_((1u << shares) - 1) {}

  /// `whole`: the tile is asked for as a whole.
  BlockShares block(const SharesAround& around, bool whole, BlockShares shares);
  [[nodiscard]] const Io& io() const { return io_; }

 private:
  BlockShares some(const SharesAround& around, BlockShares shares);
  bool code(std::size_t model, bool value) {
    io_.bit(models_.at(model), value);
    return value;
  }

  Io io_;
  AskModels& models_;
  std::uint32_t shares_, every_;
};

template <class Io>
BlockShares ShareCoder<Io>::block(const SharesAround& around, bool whole, BlockShares shares) {
  const auto kind = [this](BlockShares of) { return of == 0 ? 0u : of == every_ ? 2u : 1u; };
  std::size_t context = kind(around.west) * 3 + kind(around.north);
  context = (context * 3 + kind(around.north_west)) * 3 + kind(around.north_east);
  if (shares_ == 1 || code(kAllLightsModels + context * 2 + (whole ? 1 : 0), shares == every_))
    return static_cast<BlockShares>(every_);
  return some(around, shares);
}

/// Codes shares that are not all, but some.
template <class Io>
BlockShares ShareCoder<Io>::some(const SharesAround& around, BlockShares shares) {
  const auto unless_all = [this](BlockShares of) { return of == every_ ? 0u : of; };
  const std::uint32_t apart = unless_all(around.west) | unless_all(around.north) |
                              unless_all(around.north_west) | unless_all(around.north_east);
  std::uint32_t coded = 0;
  for (std::uint32_t share = 0; share < shares_; ++share) {
    bool bit = coded == 0;
    // The last bit makes the bits differ if no other does.
    if (share + 1 < shares_ || (coded != 0 && coded != every_ >> 1)) {
      const auto has = [share](BlockShares of) { return std::uint32_t{of} >> share & 1; };
      const auto kind = [&](BlockShares of) {
        return of == 0 ? 0u : has(of) == 0 ? 1u : of == every_ ? 2u : 3u;
      };
      std::uint32_t context = kind(around.west) * 4 + kind(around.north);
      context = (context * 2 + has(around.north_west)) * 2 + has(around.north_east);
      context = (context * 2 + (coded != 0 ? 1 : 0)) * 2 + (apart >> share >> 1 != 0 ? 1 : 0);
      bit = code(kShareModels + context, (shares >> share & 1) != 0);
    }
    coded |= (bit ? 1u : 0u) << share;
  }
  return static_cast<BlockShares>(coded);
}

}  // namespace

template <class Io>
const typename AskCoder<Io>::Tile* AskCoder<Io>::near(std::uint32_t tile, int dx, int dy) const {
  const auto columns = static_cast<std::int64_t>(columns_);
  const std::int64_t column = tile % columns_ + std::int64_t{dx};
  const std::int64_t at = static_cast<std::int64_t>(coded_.size()) + dy * columns + dx;
  if (column < 0 || column >= columns || at < 0) return nullptr;
  return &coded_[static_cast<std::size_t>(at)];
}

template <class Io>
void AskCoder<Io>::tile(std::uint32_t tile, RequestedTile& requested) {
  const Tile *west = near(tile, -1, 0), *north = near(tile, 0, -1);
  const Tile *north_west = near(tile, -1, -1), *north_east = near(tile, 1, -1);
  const auto any_of = [](const Tile* other) {
    return other == nullptr ? kUnknownCell : Neighbour{other->any};
  };
  Tile coded{.any = requested.any()};
  cell({.west = any_of(west),
        .north = any_of(north),
        .north_west = any_of(north_west),
        .north_east = any_of(north_east)},
       coded.any);
  if (coded.any != kNoBlocks) {
    for (std::uint32_t share = 0; share < shares_; ++share)
      for (std::uint32_t block = 0; block < 16; ++block)
        coded.blocks[block] |= static_cast<BlockShares>((requested.shares[share] >> block & 1u) << share);
    shares(west, north, north_west, north_east, coded);
    requested = {};
    for (std::uint32_t share = 0; share < shares_; ++share)
      for (std::uint32_t block = 0; block < 16; ++block)
        requested.shares[share] |= static_cast<BlockBits>((coded.blocks[block] >> share & 1u) << block);
  }
  coded_.push_back(coded);
}

template <class Io>
void AskCoder<Io>::cell(const Neighbours& around, Cell& cell) {
  const Touch west = touch(around.west, kLastColumn), north = touch(around.north, kLastRow);
  const std::uint32_t north_west = three_of(touch(around.north_west, kLowerRight));
  const std::uint32_t north_east = three_of(touch(around.north_east, kLowerLeft));
  const std::size_t context = ((west * 4u + north) * 3 + north_west) * 3 + north_east;
  if (!code(kAnyModels + context, cell != kEmptyCell))
    cell = kEmptyCell;
  else if (code(kEveryModels + std::size_t{west} * 4 + north, cell == kFullCell))
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
        bit = code(kBlockModels + std::size_t{wide} * kBitContexts + bit_context(row, border, x),
                   (cell >> at & 1) != 0);
      }
      row |= (bit ? 4u : 0u) << x;
      coded |= (bit ? 1u : 0u) << at;
    }
    border.below(row);
  }
  return static_cast<Cell>(coded);
}

/// Codes the shares of the blocks of a tile that are asked for.
template <class Io>
void AskCoder<Io>::shares(const Tile* west, const Tile* north, const Tile* north_west, const Tile* north_east,
                          Tile& tile) {
  // Rows and columns 1 to 4 are the tile's blocks, row 0 and column 0 the blocks before them.
  constexpr std::size_t kColumns = 6;
  std::array<BlockShares, 5 * kColumns> grid{};
  if (north_west != nullptr) grid[0] = north_west->blocks[15];
  if (north_east != nullptr) grid[kColumns - 1] = north_east->blocks[12];
  for (std::uint32_t i = 0; i < kTileBlocks; ++i) {
    if (north != nullptr) grid[i + 1] = north->blocks[12 + i];
    if (west != nullptr) grid[(i + 1) * kColumns] = west->blocks[kTileBlocks * i + 3];
  }
  ShareCoder<Io> coder(io_, models_, shares_);
  for (std::uint32_t rest = tile.any; rest != 0; rest &= rest - 1) {
    const auto block = static_cast<std::uint32_t>(std::countr_zero(rest));
    const std::size_t at = (block / kTileBlocks + 1) * kColumns + block % kTileBlocks + 1;
    const SharesAround around{.west = grid[at - 1],
                              .north = grid[at - kColumns],
                              .north_west = grid[at - kColumns - 1],
                              .north_east = grid[at - kColumns + 1]};
    tile.blocks[block] = grid[at] = coder.block(around, tile.any == kFullCell, tile.blocks[block]);
  }
  io_ = coder.io();
}

template class AskCoder<RangeEncoder>;
template class AskCoder<RangeDecoder>;
template class AskCoder<DecisionCounts>;

void AskPacker::start(FrameId frame, Side eye, Extent size, std::uint32_t lights,
                      std::span<const RequestedTile> requested) {
  check_eq(requested.size(), std::size_t{TileGrid{size}.count()}, "each tile has its requested blocks");
  requested_ = requested;
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
    RequestedTile requested = requested_[tile];
    coder.tile(tile, requested);
    if (encoder.size_bytes() > kMaxAskBlock_bytes) break;
    fits = encoder.mark();
  }
  // A tile has at most 18 decisions of its blocks and 9 of the shares of each, of at most 9 bits.
  static_assert((18 + 16 * (kMostShares + 1)) * 9 / 8 + 2 <= kMaxAskBlock_bytes, "any tile fits");
  encoder.rewind(fits);
  AskSlice made = slice_;
  made.tile_count = tile - slice_.first_tile;
  encoder.finish();
  made.block = block_;
  slice_.first_tile = tile;
  return made;
}

Decoded<std::uint32_t> decode_ask_slice(const AskSlice& slice, std::vector<RequestedTile>& requested,
                                        ReceivedTiles& known) {
  const TileGrid grid{slice.size};
  if (requested.size() != grid.count()) return refuse(WireRefusal::OtherMask);
  check_eq(known.size(), requested.size(), "an entry for each tile");
  check(slice.first_tile + slice.tile_count <= grid.count(), "a slice is within its grid");
  if (is_any_received(known, slice.first_tile, slice.tile_count, 1)) return 0u;
  RangeDecoder decoder(slice.block);
  AskModels models(kInitialAskModels);
  AskCoder coder(decoder, models, grid.columns(), slice.lights);
  std::vector<RequestedTile> decoded(slice.tile_count);
  for (std::uint32_t i = 0; i < slice.tile_count && !decoder.has_failed(); ++i)
    coder.tile(slice.first_tile + i, decoded[i]);
  if (!decoder.is_at_end()) return refuse(WireRefusal::Block);
  for (std::uint32_t i = 0; i < slice.tile_count; ++i) {
    requested[slice.first_tile + i] = decoded[i];
    known[slice.first_tile + i] = 1;
  }
  return slice.tile_count;
}

}  // namespace farshade
