/// Mask coder: codes one plane (up to 32 lights) of a mask's tiles: of each light the blocks that are asked
/// for in it.
///
/// Shadows have few edges, and edges go on from row to row and from light to light. So most tiles are what
/// their neighbours are, most blocks of the others too, and most rows of the blocks that an edge crosses are
/// what the rows above let expect (row_guess.h). Each of these guesses costs one decision of the range coder.
/// Only where a row's guess fails, its four pixels are coded one by one.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "stereo/codec/cells.h"
#include "stereo/codec/mask_models.h"
#include "stereo/codec/tile_bits.h"
#include "stereo/frame/requested_blocks.h"
#include "stereo/frame/tiles.h"

namespace farshade {

/// A tile of a slice after it was coded.
struct CodedTile {
  RequestedTile requested{};  ///< its blocks that are in the slice
  std::uint32_t lights = 0;   ///< those of the plane that some block is asked for in
  std::uint32_t varies = 0, value = 0;
  std::uint32_t first = 0;  ///< index of the cells of the first light that varies; the others follow
};

/// The tiles of a slice that are coded so far. The coder looks up the neighbours here.
class CodedTiles {
 public:
  /// Starts a slice of a picture whose tiles have so many columns.
  void start(std::uint32_t columns, std::uint32_t first_tile) {
    columns_ = columns;
    first_ = first_tile;
    tiles_.clear();
    cells_.clear();
  }
  void add(const RequestedTile& requested, std::uint32_t lights, const TileBits& bits);
  void add_nothing() { tiles_.emplace_back(); }

  [[nodiscard]] std::uint32_t next() const { return first_ + static_cast<std::uint32_t>(tiles_.size()); }
  /// The tile (dx, dy) away from the next one; null if it has no light in this slice.
  [[nodiscard]] const CodedTile* near(int dx, int dy) const;
  [[nodiscard]] Neighbour cell(const CodedTile* tile, std::uint32_t light, std::uint32_t block) const {
    if (tile == nullptr || (tile->requested.of(light) >> block & 1) == 0) return kUnknownCell;
    if ((tile->varies >> light & 1) == 0) return cell_of((tile->value >> light & 1) != 0);
    return cells_[tile->first + rank(tile->varies, light)][block];
  }

  [[nodiscard]] const std::vector<CodedTile>& tiles() const { return tiles_; }
  /// Writes the lights of a tile in the form that merge_tile() takes.
  void read(const CodedTile& tile, TileBits& bits) const;

 private:
  /// The number of lights below `light` that vary.
  static std::uint32_t rank(std::uint32_t varies, std::uint32_t light) {
    return static_cast<std::uint32_t>(std::popcount(varies & ((1u << light) - 1)));
  }

  std::uint32_t columns_ = 0, first_ = 0;
  std::vector<CodedTile> tiles_;
  std::vector<TileCells> cells_;
};

/// Codes one tile after another. `Io` is RangeEncoder, RangeDecoder, or something that counts.
template <class Io>
class MaskCoder {
 public:
  /// `coded` has been started.
  MaskCoder(Io& io, MaskModels& models, CodedTiles& coded, std::uint32_t lights)
      : io_(io), models_(models), coded_(coded), lights_(lights) {}

  /// Codes whether the slice is one tile in plain bits: its first decision.
  bool form(bool is_plain) {
    io_.bit(models_.at(kPlainModel), is_plain);
    return is_plain;
  }

  /// Codes what is asked for of the next tile and adds it to the coded tiles. Lights that are not asked for
  /// cost no decision. An encoder takes `bits` as split_tile() makes them, a decoder sets them.
  void tile(const RequestedTile& requested, TileBits& bits);

  /// The same for a tile whose cells are coded as plain bits.
  void plain_tile(const RequestedTile& requested, TileBits& bits);

 private:
  void ask(const RequestedTile& requested);
  [[nodiscard]] std::uint32_t guess() const;
  bool as_guessed(TileBits& bits);
  void light(std::uint32_t light, TileBits& bits);
  void cells(std::uint32_t light, TileCells& cells);

  /// Codes one decision and returns it.
  bool code(std::size_t model, bool value) {
    io_.bit(models_.at(model), value);
    return value;
  }

  Io& io_;
  MaskModels& models_;
  CodedTiles& coded_;
  std::uint32_t lights_;
  // The tile being coded.
  RequestedTile requested_{};
  std::uint32_t requested_lights_ = 0;  ///< those of the plane that some block is asked for in
  bool whole_ = false;                  ///< all blocks are asked for in all lights of the plane
  const CodedTile *west_ = nullptr, *north_ = nullptr, *north_west_ = nullptr, *north_east_ = nullptr;
  std::uint32_t varied_ = 0;  ///< lights so far that vary
  /// Pixels that differ from the one left of them, or above them, in a light so far.
  TileCells beside_{}, over_{};
};

}  // namespace farshade
