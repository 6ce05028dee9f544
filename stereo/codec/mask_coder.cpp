#include "stereo/codec/mask_coder.h"

#include <algorithm>
#include <span>

#include "stereo/codec/decision_counts.h"

namespace farshade {
namespace {

/// What is known of `lights` in a tile, as one of three contexts: those that it has have one value each, or
/// not, or it has none of them.
std::uint32_t kind_of(const CodedTile* tile, std::uint32_t lights) {
  if (tile == nullptr || (tile->lights & lights) == 0) return 2;
  return (tile->varies & lights) != 0 ? 1 : 0;
}

/// The lights that have one value in a tile.
std::uint32_t even_lights(const CodedTile* tile) {
  return tile == nullptr ? 0 : tile->lights & ~tile->varies;
}

/// What is known of a light in a tile.
Touch state_of(const CodedTile* tile, std::uint32_t light) {
  if (tile == nullptr || (tile->lights >> light & 1) == 0) return kUnknown;
  if ((tile->varies >> light & 1) != 0) return kBoth;
  return (tile->value >> light & 1) != 0 ? kSet : kClear;
}

/// The bits of a row that differ from the one left of them. `left` is that of the first.
std::uint32_t steps_of(std::uint32_t row, std::uint32_t left) {
  return (row ^ (row << 1 | left)) & 15;
}

/// How the edges that a guess has agree with the edges of the lights before.
std::uint32_t agreement(bool any_before, bool no_edges, bool beside_agrees, bool over_agrees) {
  static constexpr std::array<std::uint8_t, 8> kAgreements{5, 4, 3, 2, 1, 1, 1, 1};
  const std::uint32_t at = (no_edges ? 4u : 0u) + (beside_agrees ? 2u : 0u) + (over_agrees ? 1u : 0u);
  return any_before ? kAgreements[at] : 0;
}

/// Codes the cells of one light in one tile. It has a copy of the coder.
template <class Io>
class CellCoder {
 public:
  /// `any_before`: a light before has edges in this tile: `beside` and `over`.
  CellCoder(const Io& io, MaskModels& models, bool any_before)
      : io_(io), models_(models), any_before_(any_before) {}

  void cell(const Neighbours& around, Cell beside, Cell over, Cell& cell);
  [[nodiscard]] const Io& io() const { return io_; }

 private:
  Cell mixed(const Neighbours& around, Cell beside, Cell over, Cell cell);
  std::uint32_t row(std::uint32_t guess, std::uint32_t left, const Border& border, std::uint32_t beside,
                    std::uint32_t over, std::uint32_t value);
  bool code(std::size_t model, bool value) {
    io_.bit(models_.at(model), value);
    return value;
  }

  Io io_;
  MaskModels& models_;
  bool any_before_;
};

/// Codes a cell that mostly has one value, that of the bits beside it.
template <class Io>
void CellCoder<Io>::cell(const Neighbours& around, Cell beside, Cell over, Cell& cell) {
  const Touch west = touch(around.west, kLastColumn), north = touch(around.north, kLastRow);
  const std::uint32_t north_east = three_of(touch(around.north_east, kLowerLeft));
  const Touch north_west = touch(around.north_west, kLowerRight);
  const bool guess = west < kBoth         ? west == kSet
                     : north < kBoth      ? north == kSet
                     : north_east < kBoth ? north_east == kSet
                                          : north_west == kSet;
  const std::uint32_t edges = !any_before_ ? 0 : (beside | over) == 0 ? 1 : 2;
  const std::size_t context = ((west * 4u + north) * 3 + north_east) * 3 + edges;
  if (!code(kCellModels + context, cell != cell_of(guess)))
    cell = cell_of(guess);
  else if (!code(kMixedModels + context, is_mixed(cell)))
    cell = cell_of(!guess);
  else
    cell = mixed(around, beside, over, cell);
}

/// Codes a cell whose bits differ, row by row.
template <class Io>
Cell CellCoder<Io>::mixed(const Neighbours& around, Cell beside, Cell over, Cell cell) {
  Border border(around);
  const std::uint32_t west_unknown = around.west == kUnknownCell ? 1 : 0;
  const std::uint32_t north_unknown = around.north == kUnknownCell ? 2 : 0;
  std::uint32_t coded = 0;
#pragma GCC unroll 4
  for (std::uint32_t y = 0; y < 4; ++y) {
    const std::uint32_t left = border.left_of(y);
    const std::uint32_t beside_row = beside >> 4 * y & 15u, over_row = over >> 4 * y & 15u;
    const RowGuess guess = kRowGuesses[guess_index(left, border)];
    const std::uint32_t before =
        agreement(any_before_, (beside_row | over_row) == 0, beside_row == steps_of(guess.bits, left >> 1),
                  over_row == (guess.bits ^ (border.above >> 2 & 15)));
    const bool one_value = y == 3 && (coded == 0 || coded == 0xfff);
    // The last row cannot continue a cell of one value, since the cell's bits differ.
    const bool must_differ = one_value && guess.bits == (coded & 15);
    const std::uint32_t unknown = west_unknown | (y == 0 ? north_unknown : 0);
    const std::size_t context = ((guess.class_ * 6u + before) * 2 + (one_value ? 1 : 0)) * 4 + unknown;
    std::uint32_t bits = cell >> 4 * y & 15u;
    if (must_differ || code(kRowModels + context, bits != guess.bits))
      bits = row(guess.bits, left, border, beside_row, over_row, bits);
    else
      bits = guess.bits;
    coded |= bits << 4 * y;
    border.below(left | bits << 2);
  }
  return static_cast<Cell>(coded);
}

/// Codes the bits of a row that is not as guessed.
template <class Io>
std::uint32_t CellCoder<Io>::row(std::uint32_t guess, std::uint32_t left, const Border& border,
                                 std::uint32_t beside, std::uint32_t over, std::uint32_t value) {
  std::uint32_t row = left;
  std::uint32_t differs = 0;
#pragma GCC unroll 4
  for (std::uint32_t x = 0; x < 4; ++x) {
    std::uint32_t bit = ~guess >> x & 1;  // the last bit must differ if no other does
    if (x < 3 || differs != 0) {
      const std::uint32_t edges = (beside >> x & 1) | (over >> x & 1) << 1;
      const std::uint32_t context = (differs * 4 + edges) * kBitContexts + bit_context(row, border, x);
      bit = code(kBitModels + context, (value >> x & 1) != 0) ? 1 : 0;
    }
    differs |= bit ^ (guess >> x & 1);
    row |= bit << (x + 2);
  }
  return row >> 2;
}

/// Adds the pixels of a cell that differ from the one left of them, or above them. An unknown one does not
/// differ.
void add_edges(const Neighbours& around, std::uint32_t cell, Cell& beside, Cell& over) {
  const std::uint32_t west = around.west == kUnknownCell ? cell & 0x1111 : around.west >> 3 & 0x1111;
  const std::uint32_t north = around.north == kUnknownCell ? cell & 15 : around.north >> 12;
  beside = static_cast<Cell>(beside | (cell ^ ((cell << 1 & 0xeeee) | west)));
  over = static_cast<Cell>(over | (cell ^ ((cell << 4 & 0xfff0) | north)));
}

}  // namespace

void CodedTiles::add(const RequestedTile& requested, std::uint32_t lights, const TileBits& bits) {
  tiles_.push_back({.requested = requested,
                    .lights = lights,
                    .varies = bits.varies,
                    .value = bits.value,
                    .first = static_cast<std::uint32_t>(cells_.size())});
  for (std::uint32_t rest = bits.varies; rest != 0; rest &= rest - 1)
    cells_.push_back(bits.cells[static_cast<std::size_t>(std::countr_zero(rest))]);
}

const CodedTile* CodedTiles::near(int dx, int dy) const {
  const auto column = static_cast<std::int64_t>(next() % columns_) + dx;
  if (column < 0 || column >= static_cast<std::int64_t>(columns_)) return nullptr;
  const std::int64_t at = static_cast<std::int64_t>(tiles_.size()) + dy * std::int64_t{columns_} + dx;
  if (at < 0) return nullptr;
  const CodedTile& tile = tiles_[static_cast<std::size_t>(at)];
  return tile.lights != 0 ? &tile : nullptr;
}

void CodedTiles::read(const CodedTile& tile, TileBits& bits) const {
  bits.varies = tile.varies;
  bits.value = tile.value;
  std::size_t at = tile.first;
  for (std::uint32_t rest = tile.varies; rest != 0; rest &= rest - 1)
    bits.cells[static_cast<std::size_t>(std::countr_zero(rest))] = cells_[at++];
}

template <class Io>
void MaskCoder<Io>::ask(const RequestedTile& requested) {
  requested_ = requested;
  requested_lights_ = lights_requested(requested, lights_);
  whole_ = std::ranges::all_of(std::span(requested.shares).first(shares_of(lights_)),
                               [](BlockBits blocks) { return blocks == kAllBlocks; });
}

template <class Io>
void MaskCoder<Io>::tile(const RequestedTile& requested, TileBits& bits) {
  if (requested != requested_) ask(requested);
  bits.varies &= requested_lights_;
  bits.value &= requested_lights_;
  if (requested_lights_ != 0) {
    west_ = coded_.near(-1, 0);
    north_ = coded_.near(0, -1);
    north_west_ = coded_.near(-1, -1);
    north_east_ = coded_.near(1, -1);
    if (!as_guessed(bits)) {
      varied_ = 0;
      for (std::uint32_t rest = requested_lights_; rest != 0; rest &= rest - 1)
        light(static_cast<std::uint32_t>(std::countr_zero(rest)), bits);
    }
  }
  coded_.add(requested, requested_lights_, bits);
}

template <class Io>
void MaskCoder<Io>::plain_tile(const RequestedTile& requested, TileBits& bits) {
  bits.varies = lights_requested(requested, lights_);
  bits.value = 0;
  for (std::uint32_t light = 0; light < lights_; ++light)
    for (std::uint32_t block = 0; block < 16; ++block)
      if ((requested.of(light) >> block & 1) != 0) io_.plain(bits.cells[light][block]);
  coded_.add(requested, bits.varies, bits);
}

/// For each light its value in the tile left, if it has one there, else in the tile above, else in the pixel
/// left of the tile's first, else in the pixel above that, else 0.
template <class Io>
std::uint32_t MaskCoder<Io>::guess() const {
  const std::uint32_t left = even_lights(west_), above = even_lights(north_) & ~left;
  std::uint32_t word = (left != 0 ? west_->value & left : 0) | (above != 0 ? north_->value & above : 0);
  for (std::uint32_t rest = requested_lights_ & ~(left | above); rest != 0; rest &= rest - 1) {
    const auto light = static_cast<std::uint32_t>(std::countr_zero(rest));
    Touch beside = touch(coded_.cell(west_, light, 3), kUpperRight);
    if (beside == kUnknown) beside = touch(coded_.cell(north_, light, 12), kLowerLeft);
    if (beside == kSet) word |= 1u << light;
  }
  return word & requested_lights_;
}

/// Codes whether all lights have their guess in all pixels. Then the tile is complete.
template <class Io>
bool MaskCoder<Io>::as_guessed(TileBits& bits) {
  const std::uint32_t west = kind_of(west_, requested_lights_), north = kind_of(north_, requested_lights_);
  const std::uint32_t north_east = kind_of(north_east_, requested_lights_), guessed = guess();
  const bool agree =
      west == 0 && north == 0 &&
      ((west_->value ^ north_->value) & west_->lights & north_->lights & requested_lights_) == 0;
  const std::size_t context =
      (((west * 3 + north) * 3 + north_east) * 2 + (agree ? 1 : 0)) * 2 + (whole_ ? 1 : 0);
  if (code(kTileModels + context, bits.varies != 0 || bits.value != guessed)) return false;
  bits.varies = 0;
  bits.value = guessed;
  return true;
}

template <class Io>
void MaskCoder<Io>::light(std::uint32_t light, TileBits& bits) {
  const std::uint32_t mask = 1u << light;
  const Touch west = state_of(west_, light), north = state_of(north_, light);
  const bool is_first = (requested_lights_ & (mask - 1)) == 0;
  const std::size_t before = is_first ? 0 : varied_ == 0 ? 1 : 2;
  const std::size_t whole = requested_.of(light) == kAllBlocks ? 0 : 1;
  if (code(kLightModels + ((whole * 3 + before) * 4 + west) * 4 + north, (bits.varies & mask) != 0)) {
    bits.varies |= mask;
    bits.value &= ~mask;
    if (varied_ == 0) {
      beside_.fill(0);
      over_.fill(0);
    }
    cells(light, bits.cells[light]);
    varied_ |= mask;
    return;
  }
  bits.varies &= ~mask;
  const std::size_t left = three_of(touch(coded_.cell(west_, light, 3), kUpperRight));
  const std::uint32_t above = three_of(touch(coded_.cell(north_, light, 12), kLowerLeft));
  const bool set = code(kValueModels + left * 3 + above, (bits.value & mask) != 0);
  bits.value = set ? bits.value | mask : bits.value & ~mask;
}

/// Codes the cells of a light that varies in the blocks that are asked for in it.
template <class Io>
void MaskCoder<Io>::cells(std::uint32_t light, TileCells& cells) {
  // Rows and columns 1 to 4 are the tile's cells, row 0 and column 0 the cells before them.
  constexpr std::uint32_t kColumns = 6;
  std::array<Neighbour, 5 * kColumns> grid;
  grid.fill(kUnknownCell);
  grid[0] = coded_.cell(north_west_, light, 15);
  grid[kColumns - 1] = coded_.cell(north_east_, light, 12);
  for (std::uint32_t i = 0; i < kTileBlocks; ++i) {
    grid[i + 1] = coded_.cell(north_, light, 12 + i);
    grid[std::size_t{i + 1} * kColumns] = coded_.cell(west_, light, kTileBlocks * i + 3);
  }
  const bool more_follow = requested_lights_ >> light >> 1 != 0;
  const std::uint32_t requested = requested_.of(light);
  CellCoder<Io> coder(io_, models_, varied_ != 0);
  for (std::uint32_t block = 0; block < 16; ++block) {
    if ((requested >> block & 1) == 0) continue;
    const std::uint32_t at = (block / kTileBlocks + 1) * kColumns + block % kTileBlocks + 1;
    const Neighbours around{.west = grid[at - 1],
                            .north = grid[at - kColumns],
                            .north_west = grid[at - kColumns - 1],
                            .north_east = grid[at - kColumns + 1]};
    coder.cell(around, beside_[block], over_[block], cells[block]);
    grid[at] = cells[block];
    if (more_follow) add_edges(around, cells[block], beside_[block], over_[block]);
  }
  io_ = coder.io();
}

template class MaskCoder<RangeEncoder>;
template class MaskCoder<RangeDecoder>;
template class MaskCoder<DecisionCounts>;

}  // namespace farshade
