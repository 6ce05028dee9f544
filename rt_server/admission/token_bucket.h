/// TokenBucket: limits how often something may happen. It holds the tokens of one second at most, but one in
/// any case.
#pragma once

#include <algorithm>

#include "stereo/base/clock.h"

namespace farshade {

class TokenBucket {
 public:
  /// Full. `per_second` > 0.
  explicit TokenBucket(double per_second) : per_second_(per_second), left_(std::max(per_second, 1.0)) {}

  /// Whether a whole token is there at `now`. A clock that steps back brings no tokens.
  [[nodiscard]] bool has_token(Time now) {
    const double earned = std::max(0.0, seconds_of(now - refilled_)) * per_second_;
    left_ = std::min(std::max(per_second_, 1.0), left_ + earned);
    refilled_ = std::max(refilled_, now);
    return left_ >= 1;
  }
  /// Only if has_token().
  void take() { left_ -= 1; }

 private:
  double per_second_, left_;
  Time refilled_{};  ///< when left_ was last brought up to date
};

}  // namespace farshade
