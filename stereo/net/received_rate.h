/// ReceivedRate: the received rate over the last half second of arrivals, on the client's clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "stereo/base/clock.h"

namespace farshade {

class ReceivedRate {
 public:
  void add(Time arrived, std::size_t bytes);
  /// Returns nothing before 100 ms of arrivals are known.
  [[nodiscard]] std::optional<double> bytes_per_second() const;

 private:
  static constexpr Duration kBucket = std::chrono::milliseconds(25);
  static constexpr std::int64_t kBuckets = 21;  ///< the newest is incomplete and not counted

  std::array<std::uint64_t, kBuckets> bytes_{};
  std::int64_t first_ = 0, newest_ = 0;  ///< bucket numbers
  bool any_ = false;
};

}  // namespace farshade
