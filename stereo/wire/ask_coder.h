/// Ask coder: packs the blocks that a request asks for into AskSlices that decode independently.
///
/// A tile's blocks are one cell (cells.h). Asked blocks follow shadow edges, so they are thin curves.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/frame/asked_blocks.h"
#include "stereo/frame/known_tiles.h"
#include "stereo/frame/tiles.h"
#include "stereo/wire/cells.h"
#include "stereo/wire/mask_models.h"
#include "stereo/wire/messages.h"

namespace farshade {

// The first model of each kind of decision.
inline constexpr std::size_t kAnyModels = 0;                   ///< 4 x 4 x 3 x 3
inline constexpr std::size_t kEveryModels = kAnyModels + 144;  ///< 4 x 4
inline constexpr std::size_t kBlockModels = kEveryModels + 16;
inline constexpr std::size_t kAskModels = kBlockModels + 4 * kBitContexts;

/// Probabilities of a 0 in 1/256: wire_bench --train.
extern const std::array<std::uint8_t, kAskModels> kInitialAskModels;
using AskModels = ModelSet<kAskModels>;

/// Codes one tile after another. `Io` as for MaskCoder.
template <class Io>
class AskCoder {
 public:
  AskCoder(Io& io, AskModels& models, std::uint32_t columns) : io_(io), models_(models), columns_(columns) {}

  /// Codes the next tile. An encoder takes `blocks`, a decoder sets it.
  void tile(std::uint32_t tile, BlockBits& blocks);

 private:
  [[nodiscard]] Neighbour near(std::uint32_t tile, int dx, int dy) const;
  Cell mixed(const Neighbours& around, Cell cell);
  bool code(std::size_t model, bool value) {
    io_.bit(models_.at(model), value);
    return value;
  }

  Io& io_;
  AskModels& models_;
  std::uint32_t columns_;
  std::vector<Cell> coded_;
};

/// Packs one eye after another.
///
///     packer.start(frame, eye, size, asked);
///     while (const std::optional<AskSlice> slice = packer.next()) send(*slice);
class AskPacker {
 public:
  /// `asked` has one entry for each tile of a view of `size`. It must stay unchanged until the last slice.
  void start(FrameId frame, Side eye, Extent size, std::span<const BlockBits> asked);

  /// Returns the next slice, or nothing after the last. Its block is valid until the next call.
  [[nodiscard]] std::optional<AskSlice> next();

 private:
  std::span<const BlockBits> asked_;
  AskSlice slice_;  ///< fields that all slices of this eye share, and the next slice's first tile
  std::vector<std::byte> block_;
};

/// Writes the tiles of a decoded slice into `asked` and sets their entries in `known` to 1. Both have one
/// entry for each tile. Returns how many of the entries in `known` were 0 before: 0 for a duplicate. Refuses
/// a slice whose grid has another number of tiles, and a block that does not end with the slice's tiles.
/// After a refusal asked and known are unchanged.
[[nodiscard]] Decoded<std::uint32_t> decode_ask_slice(const AskSlice& slice, std::vector<BlockBits>& asked,
                                                      KnownTiles& known);

}  // namespace farshade
