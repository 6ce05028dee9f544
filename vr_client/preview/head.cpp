#include "vr_client/preview/head.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/check.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

double clamped(double pitch_rad) {
  return std::clamp(pitch_rad, -kSteepestPitch_rad, kSteepestPitch_rad);
}

double pitch_of(const glm::dquat& rotation) {
  const glm::dvec3 ahead = rotation * glm::dvec3(0, 0, -1);
  return std::atan2(ahead.y, std::hypot(ahead.x, ahead.z));
}

/// Chord length / arc length of an arc that turns by `turn_rad`: sin(a/2) / (a/2).
double chord_share(double turn_rad) {
  const double half = 0.5 * turn_rad;
  return std::abs(half) < 1e-4 ? 1.0 - half * half / 6.0 : std::sin(half) / half;
}

bool is_finite(const HeadInput& input) {
  return std::isfinite(input.turn_px.x) && std::isfinite(input.turn_px.y) && std::isfinite(input.walk.x) &&
         std::isfinite(input.walk.y) && std::isfinite(input.walk.z);
}

}  // namespace

SimulatedHead::SimulatedHead(const Rigid<Stage, Head>& start)
    : position_(start.translation),
      yaw_rad_(heading_rad(start.rotation)),
      pitch_rad_(clamped(pitch_of(start.rotation))) {}

void SimulatedHead::step(const HeadInput& input, Duration span) {
  check(is_finite(input) && span >= Duration::zero(), "the head gets finite input and a span of at least 0");
  const double turn_rad = -input.turn_px.x * kTurn_rad_per_px;
  const double speed_m_per_s = input.speed == MoveSpeed::Run ? kRunningSpeed_m_per_s : kWalkingSpeed_m_per_s;
  const double distance_m = speed_m_per_s * seconds_of(std::min(span, kLongestStep));
  const glm::dvec3 walk = input.walk / std::max(1.0, glm::length(input.walk));

  const glm::dquat midway = rotation_exp({0.0, yaw_rad_ + 0.5 * turn_rad, 0.0});
  position_ += distance_m * (chord_share(turn_rad) * (midway * glm::dvec3(walk.x, 0.0, walk.z)) +
                             glm::dvec3(0.0, walk.y, 0.0));
  yaw_rad_ = std::remainder(yaw_rad_ + turn_rad, 2.0 * std::numbers::pi);
  pitch_rad_ = clamped(pitch_rad_ - input.turn_px.y * kTurn_rad_per_px);
}

Rigid<Stage, Head> SimulatedHead::stage_from_head() const {
  return {glm::normalize(rotation_exp({0.0, yaw_rad_, 0.0}) * rotation_exp({pitch_rad_, 0.0, 0.0})),
          position_};
}

}  // namespace farshade
