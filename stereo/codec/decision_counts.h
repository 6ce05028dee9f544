/// DecisionCounts: counts the decisions that an encoder makes with each model instead of coding them. The
/// initial probabilities come from such counts (wire_bench --train).
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>

#include "stereo/codec/range_coder.h"

namespace farshade {

class DecisionCounts {
 public:
  /// How often each model was 0 and 1.
  using Counts = std::unordered_map<const BitModel*, std::array<std::uint64_t, 2>>;

  explicit DecisionCounts(Counts& counts) : counts_(&counts) {}

  void bit(BitModel& model, const bool& value) { ++(*counts_)[&model][value ? 1 : 0]; }
  void plain(const std::uint16_t&) {}

 private:
  Counts* counts_;
};

}  // namespace farshade
