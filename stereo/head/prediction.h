/// Predictor: where the head will be when masks asked for now are used. It is fed every pose the runtime
/// gives and holds the rules for time stamps; the filters themselves are in pose_filters.h, and how they
/// compare on recorded heads is in docs/prediction.md.
#pragma once

#include <optional>
#include <string_view>
#include <variant>

#include "stereo/base/clock.h"
#include "stereo/head/pose_filters.h"

namespace farshade {

enum class PredictorKind { Hold, ConstantVelocity, DoubleExponential, Kalman };
inline constexpr PredictorKind kPredictorKinds[] = {PredictorKind::Hold, PredictorKind::ConstantVelocity,
                                                    PredictorKind::DoubleExponential, PredictorKind::Kalman};
inline constexpr PredictorKind kDefaultPredictor = PredictorKind::Kalman;

/// "hold", "constant-velocity", "double-exponential", "kalman"
[[nodiscard]] std::string_view to_string(PredictorKind kind);
[[nodiscard]] std::optional<PredictorKind> parse_predictor(std::string_view name);

using PoseFilter = std::variant<HoldFilter, ConstantVelocityFilter, DoubleExponentialFilter, KalmanFilter>;

/// The filter of a kind, with the constants chosen on recorded heads.
[[nodiscard]] PoseFilter make_filter(PredictorKind kind);

/// After a gap longer than this the head's velocity is anyone's guess: it is held until the next pose.
inline constexpr Duration kLongestGap = std::chrono::milliseconds(250);
/// A head that moved faster than this, and further than a jitter, was put elsewhere (recentred, say):
/// likewise.
inline constexpr double kFastestTurn_rad_s = 40, kFastestWay_m_s = 20;
inline constexpr double kJitter_rad = 0.05, kJitter_m = 0.05;
/// Predictions further ahead are those for this lead.
inline constexpr Duration kFarthestLead = std::chrono::milliseconds(500);
/// How far off unit a rotation may be to be taken (and normalised), and how far out a head may be.
inline constexpr double kPoseUnitTolerance = 1e-2, kFarthestPose_m = 1e9;

/// A value: copies are independent, nothing is allocated.
class Predictor {
 public:
  explicit Predictor(PredictorKind kind = kDefaultPredictor) : Predictor(make_filter(kind)) {}
  explicit Predictor(const PoseFilter& filter, Duration longest_gap = kLongestGap)
      : filter_(filter), longest_gap_(longest_gap) {}

  /// Takes the head's pose at `time`. Ignored: a stamp not after the newest one; a pose that is not finite,
  /// off unit or out too far.
  void observe(Time time, const HeadPose& stage_from_head);

  /// The pose at `time`. Not after the newest observation: that observation as it was given. Before any:
  /// identity.
  [[nodiscard]] HeadPose predict(Time time) const;

  /// The head's estimated body twist (rad/s, m/s, in head axes) at the newest observation.
  [[nodiscard]] Twist velocity() const;

  /// Stamp of the newest observation taken.
  [[nodiscard]] std::optional<Time> newest() const { return newest_; }

 private:
  PoseFilter filter_;
  Duration longest_gap_;
  std::optional<Time> newest_;
  HeadPose pose_;
};

}  // namespace farshade
