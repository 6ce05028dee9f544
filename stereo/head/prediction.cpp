#include "stereo/head/prediction.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace farshade {
namespace {

// Chosen on EyeNavGS users 101, 102, 104 and 103 at 72 Hz (docs/prediction.md) by the p95 of the error 50 and
// 100 ms ahead. Pitch and roll go back and forth (steps, nods), yaw continues: one decay time for all axes
// costs 5 % of the p95 at 50 ms and 8 % at 100 ms. The same holds for the vertical and the forward motion of
// a walk.
constexpr KalmanTuning kKalman{.angular_fade_s = {0.1, 1.0, 0.08},
                               .linear_fade_s = {2.0, 0.3, 2.0},
                               .angular_drive = 0.9,
                               .linear_drive = 0.09,
                               .angular_noise = 3e-4,
                               .linear_noise = 3e-4};

/// later - earlier for later >= earlier, without overflow.
double seconds_between(Time earlier, Time later) {
  return static_cast<double>(static_cast<std::uint64_t>(ns_of(later)) -
                             static_cast<std::uint64_t>(ns_of(earlier))) *
         1e-9;
}

bool is_pose(const HeadPose& pose) {
  // Comparisons are false for NaN.
  return std::abs(glm::length(pose.rotation) - 1.0) <= kPoseUnitTolerance &&
         glm::length(pose.translation) <= kFarthestPose_m;
}

bool is_jump(const HeadPose& before, const HeadPose& now, double step_s) {
  return angle_between_rad(before.rotation, now.rotation) > kJitter_rad + kFastestTurn_rad_s * step_s ||
         glm::length(now.translation - before.translation) > kJitter_m + kFastestWay_m_s * step_s;
}

/// Normalises the rotation, unless it is unit up to rounding: predict() returns the newest pose bit for bit.
HeadPose with_unit_rotation(const HeadPose& pose) {
  const double off = glm::dot(pose.rotation, pose.rotation) - 1.0;
  if (std::abs(off) <= 8.0 * std::numeric_limits<double>::epsilon()) return pose;
  return {glm::normalize(pose.rotation), pose.translation};
}

}  // namespace

std::string_view to_string(PredictorKind kind) {
  switch (kind) {
    case PredictorKind::Hold:
      return "hold";
    case PredictorKind::Kalman:
      return "kalman";
  }
  return "";
}

std::optional<PredictorKind> parse_predictor(std::string_view name) {
  for (const PredictorKind kind : kPredictorKinds)
    if (name == to_string(kind)) return kind;
  return std::nullopt;
}

PoseFilter make_filter(PredictorKind kind) {
  if (kind == PredictorKind::Kalman) return KalmanFilter(kKalman);
  return HoldFilter{};
}

void Predictor::observe(Time time, const HeadPose& stage_from_head) {
  if ((newest_ && time <= *newest_) || !is_pose(stage_from_head)) return;
  const HeadPose before = std::exchange(pose_, with_unit_rotation(stage_from_head));
  const double step_s = newest_ ? seconds_between(*newest_, time) : 0.0;
  const bool starts = !newest_ || step_s > seconds_of(longest_gap_) || is_jump(before, pose_, step_s);
  newest_ = time;
  std::visit([&](auto& filter) { starts ? filter.start(pose_) : filter.step(step_s, pose_); }, filter_);
}

HeadPose Predictor::predict(Time time) const {
  if (!newest_ || time <= *newest_) return pose_;
  const double lead_s = std::min(seconds_between(*newest_, time), seconds_of(kFarthestLead));
  return std::visit([&](const auto& filter) { return filter.ahead(lead_s); }, filter_);
}

Twist Predictor::velocity() const {
  return std::visit([](const auto& filter) { return filter.velocity(); }, filter_);
}

}  // namespace farshade
