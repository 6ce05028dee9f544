/// PausableClock: a clock that another clock drives, and that its owner can stop.
#pragma once

#include <optional>

#include "stereo/base/clock.h"

namespace farshade {

inline const SteadyClock kSteadyClock;

class PausableClock final : public Clock {
 public:
  /// Shows the time of `base` until it is first stopped. Keeps a reference.
  explicit PausableClock(const Clock& base = kSteadyClock) : base_(base) {}

  [[nodiscard]] Time now() const override { return at(base_.now()); }

  /// What this clock showed at the time `base_time` of its base, or will show if it is not stopped before.
  /// Right from the end of the last stop but one on.
  [[nodiscard]] Time at(Time base_time) const {
    if (!stop_ || base_time < stop_->from) return base_time - stopped_before_;
    if (!stop_->until || base_time < *stop_->until) return stop_->from - stopped_before_;
    return base_time - stopped_before_ - (*stop_->until - stop_->from);
  }

  /// The clock stands still until resume(). A clock that stands still goes on doing so.
  void stop() {
    if (stop_ && !stop_->until) return;
    if (stop_) stopped_before_ += *stop_->until - stop_->from;
    stop_ = Stop{base_.now(), std::nullopt};
  }
  void resume() {
    if (stop_ && !stop_->until) stop_->until = base_.now();
  }

 private:
  /// On the base.
  struct Stop {
    Time from;
    std::optional<Time> until;
  };
  const Clock& base_;
  Duration stopped_before_{};  ///< all stops but the last
  std::optional<Stop> stop_;   ///< the last
};

}  // namespace farshade
