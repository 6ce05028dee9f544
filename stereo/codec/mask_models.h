/// The contexts of the mask coder, and the probabilities with which each slice starts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "stereo/codec/cells.h"
#include "stereo/codec/range_coder.h"
#include "stereo/codec/row_guess.h"

namespace farshade {

// The first model of each kind of decision. PROTOCOL.md describes the decisions and their contexts.
inline constexpr std::size_t kPlainModel = 0;
inline constexpr std::size_t kTileModels = 1;                   ///< 3 x 3 x 3 x 2 x 2
inline constexpr std::size_t kLightModels = kTileModels + 108;  ///< 2 x 3 x 4 x 4
inline constexpr std::size_t kValueModels = kLightModels + 96;  ///< 3 x 3
inline constexpr std::size_t kCellModels = kValueModels + 9;    ///< 4 x 4 x 3 x 3
inline constexpr std::size_t kMixedModels = kCellModels + 144;  ///< 4 x 4 x 3 x 3
inline constexpr std::size_t kRowModels = kMixedModels + 144;   ///< 8 x 6 x 2 x 4
inline constexpr std::size_t kBitModels = kRowModels + 384;     ///< 2 x 4 x 64
inline constexpr std::size_t kMaskModels = kBitModels + std::size_t{8} * kBitContexts;

/// Probabilities of a 0 in 1/256, from the traced masks of two scenes: wire_bench --train.
extern const std::array<std::uint8_t, kMaskModels> kInitialMaskModels;

template <std::size_t kCount>
class ModelSet {
 public:
  explicit ModelSet(const std::array<std::uint8_t, kCount>& initial) {
    for (std::size_t i = 0; i < kCount; ++i) models_[i] = BitModel(initial[i]);
  }
  [[nodiscard]] BitModel& at(std::size_t model) { return models_[model]; }

 private:
  std::array<BitModel, kCount> models_;
};
using MaskModels = ModelSet<kMaskModels>;

}  // namespace farshade
