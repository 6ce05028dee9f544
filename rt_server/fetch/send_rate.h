/// SendRate: how fast all scene connections together may send, so that masks come first. A token bucket whose
/// rate falls while masks are sent. A value without threads or clocks.
#pragma once

#include <cstddef>

#include "stereo/base/clock.h"

namespace farshade {

class SendRate {
 public:
  explicit SendRate(double bytes_per_second) : full_(bytes_per_second) {}

  /// Part of the rate that is left to scenes while masks are sent.
  static constexpr double kBesideMasks = 0.25;
  enum class Masks { Idle, Sent };

  /// Takes `bytes` if less than kMostAhead of sending is due; otherwise returns how long to wait.
  [[nodiscard]] Duration take(std::size_t bytes, Masks masks, Time now);

 private:
  static constexpr Duration kMostAhead = std::chrono::milliseconds(5);

  double full_;
  Time free_at_{};  ///< when all that was taken has been sent
};

}  // namespace farshade
