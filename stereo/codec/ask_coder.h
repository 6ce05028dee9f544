/// Ask coder: packs what a request asks for into AskSlices that decode independently.
///
/// The blocks of a tile that are asked for in any light are one cell (cells.h). Requested blocks follow
/// shadow edges, so they are thin curves. Then each of these blocks has its shares of the lights: an edge is
/// mostly that of one light, and it goes on from block to block; at borders and for a refresh, all lights are
/// asked for.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/codec/cells.h"
#include "stereo/codec/mask_models.h"
#include "stereo/frame/received_tiles.h"
#include "stereo/frame/requested_blocks.h"
#include "stereo/frame/tiles.h"
#include "stereo/messages/messages.h"

namespace farshade {

// The first model of each kind of decision.
inline constexpr std::size_t kAnyModels = 0;                   ///< 4 x 4 x 3 x 3
inline constexpr std::size_t kEveryModels = kAnyModels + 144;  ///< 4 x 4
inline constexpr std::size_t kBlockModels = kEveryModels + 16;
inline constexpr std::size_t kAllLightsModels =
    kBlockModels + std::size_t{4} * kBitContexts;                    ///< 3 x 3 x 3 x 3 x 2
inline constexpr std::size_t kShareModels = kAllLightsModels + 162;  ///< 4 x 4 x 2 x 2 x 2 x 2
inline constexpr std::size_t kAskModels = kShareModels + 256;

/// Probabilities of a 0 in 1/256: wire_bench --train.
extern const std::array<std::uint8_t, kAskModels> kInitialAskModels;
using AskModels = ModelSet<kAskModels>;

/// The shares of the lights that a block is asked for in, as bits; none if it is not asked for.
using BlockShares = std::uint8_t;

/// Codes one tile after another. `Io` as for MaskCoder.
template <class Io>
class AskCoder {
 public:
  /// For tiles in so many columns, and masks of so many lights.
  AskCoder(Io& io, AskModels& models, std::uint32_t columns, std::uint32_t lights)
      : io_(io), models_(models), columns_(columns), shares_(shares_of(lights)) {}

  /// Codes the next tile. An encoder takes `requested`, a decoder sets it.
  void tile(std::uint32_t tile, RequestedTile& requested);

 private:
  struct Tile {
    Cell any = kEmptyCell;
    std::array<BlockShares, 16> blocks{};
  };

  [[nodiscard]] const Tile* near(std::uint32_t tile, int dx, int dy) const;
  void cell(const Neighbours& around, Cell& cell);
  Cell mixed(const Neighbours& around, Cell cell);
  void shares(const Tile* west, const Tile* north, const Tile* north_west, const Tile* north_east,
              Tile& tile);
  bool code(std::size_t model, bool value) {
    io_.bit(models_.at(model), value);
    return value;
  }

  Io& io_;
  AskModels& models_;
  std::uint32_t columns_, shares_;
  std::vector<Tile> coded_;
};

/// Packs one eye after another.
///
///     packer.start(frame, eye, size, lights, requested);
///     while (const std::optional<AskSlice> slice = packer.next()) send(*slice);
class AskPacker {
 public:
  /// `requested` has one entry for each tile of a view of `size`. It must stay unchanged until the last
  /// slice.
  void start(FrameId frame, Side eye, Extent size, std::uint32_t lights,
             std::span<const RequestedTile> requested);

  /// Returns the next slice, or nothing after the last. Its block is valid until the next call.
  [[nodiscard]] std::optional<AskSlice> next();

 private:
  std::span<const RequestedTile> requested_;
  AskSlice slice_;  ///< fields that all slices of this eye share, and the next slice's first tile
  std::vector<std::byte> block_;
};

/// Writes the tiles of a decoded slice into `requested` and sets their entries in `known` to 1. Both have one
/// entry for each tile. Returns the number of these tiles; 0 for a duplicate, which is a slice with a
/// received tile: it is not decoded and changes nothing. Refuses a slice whose grid has another number of
/// tiles, and a block that does not end with the slice's tiles. After a refusal `requested` and `known` are
/// unchanged. The caller checks that slice.lights is the number of lights that it has.
[[nodiscard]] Decoded<std::uint32_t> decode_ask_slice(const AskSlice& slice,
                                                      std::vector<RequestedTile>& requested,
                                                      ReceivedTiles& known);

}  // namespace farshade
