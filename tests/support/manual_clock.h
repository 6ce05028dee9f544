/// A clock for tests.
#pragma once

#include "stereo/base/clock.h"

namespace farshade {

/// A clock that its owner advances. It never goes back.
class ManualClock final : public Clock {
 public:
  [[nodiscard]] Time now() const override { return now_; }
  void advance_to(Time time) {
    if (time > now_) now_ = time;
  }

 private:
  Time now_{};
};

}  // namespace farshade
