/// ArrivalClock: when a datagram came, on the steady clock, from the kernel's time stamp on the wall clock.
/// The wall clock may be set between the two readings; then the stamps of what already waits mean nothing. A
/// value without clocks.
#pragma once

#include <algorithm>
#include <optional>

#include "stereo/base/clock.h"

namespace farshade {

class ArrivalClock {
 public:
  /// The wall clock and the steady clock may drift apart by so much between two readings: a little for the
  /// time between reading them, and 500 ppm while the wall clock is adjusted.
  static constexpr Duration kLeastDrift = std::chrono::milliseconds(2);
  static constexpr Duration kMostDrift = std::chrono::milliseconds(50);

  /// The wall clock (since 1970) and the steady clock, read one after the other. Call it before the first
  /// datagram, too.
  void read(Duration wall, Time now) {
    const Duration offset = wall - now.time_since_epoch();
    if (offset_) {
      const Duration allowed = std::min(kLeastDrift + (now - read_) / 2000, kMostDrift);
      const Duration off = offset > *offset_ ? offset - *offset_ : *offset_ - offset;
      if (off > allowed) set_ = now;
    }
    offset_ = offset;
    read_ = now;
  }

  /// When a datagram with the kernel's `stamp` came, by the last reading: not in the future, and not before
  /// the wall clock was seen to have been set. Only after read().
  [[nodiscard]] Time arrival(Duration stamp) const {
    return std::clamp(Time(stamp - *offset_), set_.value_or(Time::min()), read_);
  }

 private:
  std::optional<Duration> offset_{};  ///< wall clock minus steady clock
  std::optional<Time> set_{};         ///< when a step of the wall clock was noticed
  Time read_{};
};

}  // namespace farshade
