/// Predictor: predicts the head pose for the time at which the requested masks will be used. The caller feeds
/// it every pose of the runtime. Predictor checks poses and time stamps; kalman_filter.h has the filter.
/// docs/prediction.md has the errors on recorded heads.
#pragma once

#include <optional>
#include <string_view>
#include <variant>

#include "stereo/base/clock.h"
#include "stereo/head/kalman_filter.h"

namespace farshade {

/// The values are part of capture files. 1 and 2 were constant velocity and double exponential smoothing,
/// which were less exact than the Kalman filter on every recorded head.
enum class PredictorKind { Hold = 0, Kalman = 3 };
inline constexpr PredictorKind kPredictorKinds[] = {PredictorKind::Hold, PredictorKind::Kalman};
inline constexpr PredictorKind kDefaultPredictor = PredictorKind::Kalman;

/// "hold", "kalman"
[[nodiscard]] std::string_view to_string(PredictorKind kind);
[[nodiscard]] std::optional<PredictorKind> parse_predictor(std::string_view name);

/// Predicts that the head stays at its newest pose.
class HoldFilter {
 public:
  void start(const HeadPose& pose) { pose_ = pose; }
  void step(double, const HeadPose& pose) { pose_ = pose; }
  [[nodiscard]] HeadPose ahead(double) const { return pose_; }
  [[nodiscard]] Twist velocity() const { return {}; }

 private:
  HeadPose pose_;
};

using PoseFilter = std::variant<HoldFilter, KalmanFilter>;

/// The filter of a kind, with the constants chosen on recorded heads.
[[nodiscard]] PoseFilter make_filter(PredictorKind kind);

/// After a gap longer than this, the filter starts again: the velocity is 0 until the next pose.
inline constexpr Duration kLongestGap = std::chrono::milliseconds(250);
/// If the head moved faster than this, and further than kJitter, it was moved to another place: recentred, or
/// turned by the controller's 30 degrees (displays of 60 Hz and more show that in one frame, also while the
/// head itself turns the other way). The filter starts again.
inline constexpr double kFastestTurn_rad_s = 25, kFastestWay_m_s = 20;
inline constexpr double kJitter_rad = 0.05, kJitter_m = 0.05;
/// The longest lead. A prediction for a later time is the prediction for this lead.
inline constexpr Duration kFarthestLead = std::chrono::milliseconds(500);
/// Limits for observed poses: the length of a quaternion may differ from 1 by this (it is normalised), and a
/// head may be this far from the origin.
inline constexpr double kPoseUnitTolerance = 1e-2, kFarthestPose_m = 1e9;

/// A value type: copies are independent and no memory is allocated.
class Predictor {
 public:
  explicit Predictor(PredictorKind kind = kDefaultPredictor) : Predictor(make_filter(kind)) {}
  explicit Predictor(const PoseFilter& filter, Duration longest_gap = kLongestGap)
      : filter_(filter), longest_gap_(longest_gap) {}

  /// Observes the head pose at `time`. Ignores a stamp that is not after the newest one, and a pose that is
  /// not finite, not unit, or too far from the origin.
  void observe(Time time, const HeadPose& stage_from_head);

  /// The pose at `time`. If `time` is not after the newest observation, returns that observation unchanged;
  /// without any observation, the identity.
  [[nodiscard]] HeadPose predict(Time time) const;

  /// Estimated body twist (rad/s, m/s, in head axes) at the newest observation.
  [[nodiscard]] Twist velocity() const;

  /// Time of the newest accepted observation.
  [[nodiscard]] std::optional<Time> newest() const { return newest_; }

 private:
  PoseFilter filter_;
  Duration longest_gap_;
  std::optional<Time> newest_;
  HeadPose pose_;
};

}  // namespace farshade
