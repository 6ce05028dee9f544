#include "vr_client/preview/player.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/check.h"

namespace farshade {

Player::Player(Duration length) : length_(length) {
  check(length > Duration::zero(), "the recording has a length");
}

void Player::play() {
  if (position_ == length_) position_ = Duration::zero();
  playing_ = true;
}

void Player::scrub(Duration to) {
  position_ = std::clamp(to, Duration::zero(), length_);
}

void Player::set_speed(double speed) {
  check(!std::isnan(speed), "the speed is a number");
  speed_ = std::clamp(speed, kSlowest, kFastest);
}

void Player::advance(Duration span) {
  check(span >= Duration::zero(), "the player advances by at least 0");
  position_ = position_after(span);
  if (at_end_ == AtEnd::Hold && position_ == length_) playing_ = false;
}

Duration Player::position_after(Duration ahead) const {
  if (!playing_) return position_;
  // Computed in double, so that no span overflows. Exact below 100 days.
  const auto length_ns = static_cast<double>(length_.count());
  double at_ns = static_cast<double>(position_.count()) + static_cast<double>(ahead.count()) * speed_;
  if (at_end_ == AtEnd::Loop) {
    at_ns = std::fmod(at_ns, length_ns);
    if (at_ns < 0) at_ns += length_ns;
  }
  return Duration(std::llround(std::clamp(at_ns, 0.0, length_ns)));
}

}  // namespace farshade
