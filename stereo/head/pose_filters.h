/// The filters behind Predictor (prediction.h), each a value that can be run alone. Every one is started with
/// a pose, stepped with poses, and asked for the pose some seconds after the last. What they keep are body
/// twists, so that a head that turns about its neck is carried on along that arc, and rotations stay unit.
///
/// All steps solve their linear system exactly (damped_motion.h): any ratio of step to time constant is good,
/// and so is a step of 0. Steps and leads are finite and not negative, poses unit up to rounding, constants
/// positive.
#pragma once

#include <array>

#include "stereo/math/twist.h"

namespace farshade {

using HeadPose = Rigid<Stage, Head>;

/// The head stays where it is.
class HoldFilter {
 public:
  void start(const HeadPose& pose) { pose_ = pose; }
  void step(double step_s, const HeadPose& pose);
  [[nodiscard]] HeadPose ahead(double lead_s) const;
  [[nodiscard]] Twist velocity() const { return {}; }

 private:
  HeadPose pose_;
};

/// The screw between the last two poses goes on for ever. Poses that come in bursts are not differenced with
/// each other: the two are at least kBaseline_s apart, and until there are two the head is held.
class ConstantVelocityFilter {
 public:
  static constexpr double kBaseline_s = 0.004;

  void start(const HeadPose& pose);
  void step(double step_s, const HeadPose& pose);
  [[nodiscard]] HeadPose ahead(double lead_s) const;
  [[nodiscard]] Twist velocity() const { return velocity_; }

 private:
  HeadPose pose_, reference_, next_reference_;
  double reference_age_s_ = 0, next_reference_age_s_ = 0;
  Twist velocity_;
};

/// Double exponential smoothing: the pose smoothed once, S1, and twice, S2, extrapolated by
/// 2 S1 - S2 + (S1 - S2) lead / smoothing. Here it is kept as the once and twice smoothed body twist
/// (d S1/dt and d S2/dt), which in a vector space is the same filter and on SE(3) never leaves the group; the
/// head is taken to move on a screw between poses. A step smooths by 1 - exp(-step / smoothing).
/// Source: J. J. LaViola, "Double exponential smoothing: an alternative to Kalman filter-based predictive
/// tracking", EGVE 2003.
class DoubleExponentialFilter {
 public:
  explicit DoubleExponentialFilter(double smoothing_s) : smoothing_s_(smoothing_s) {}

  void start(const HeadPose& pose);
  void step(double step_s, const HeadPose& pose);
  [[nodiscard]] HeadPose ahead(double lead_s) const;
  [[nodiscard]] Twist velocity() const { return twice_; }

 private:
  double smoothing_s_;
  HeadPose pose_;
  Twist once_, twice_;
};

/// What KalmanFilter believes of heads, for the head's own axes x (pitch), y (yaw), z (roll).
struct KalmanTuning {
  glm::dvec3 angular_fade_s, linear_fade_s;  ///< time in which a velocity falls to 1/e; infinite: never
  double angular_drive, linear_drive;        ///< spectral density of what changes it, rad^2/s^3, m^2/s^3
  double angular_noise, linear_noise;        ///< standard deviation of a measured pose, rad, m
};

/// Error-state Kalman filter on SE(3): pose and body twist, each component of the twist a velocity that fades
/// (damped_motion.h), errors in the tangent space at the estimate. What a turn within one step mixes between
/// the components' errors is left out of the covariance (not of the pose), so that it is six of two by two.
/// Sources: J. Sola, "Quaternion kinematics for the error-state Kalman filter", 2017; S. Anderson, T. D.
/// Barfoot, "Full STEAM ahead: exactly sparse Gaussian process regression for batch continuous-time
/// trajectory estimation on SE(3)", IROS 2015, for the linear motion prior in the tangent space; R. A.
/// Singer, "Estimating optimal tracking filter performance for manned maneuvering targets", 1970, for fading.
class KalmanFilter {
 public:
  explicit KalmanFilter(const KalmanTuning& tuning) : tuning_(tuning) {}

  void start(const HeadPose& pose);
  void step(double step_s, const HeadPose& pose);
  [[nodiscard]] HeadPose ahead(double lead_s) const;
  [[nodiscard]] Twist velocity() const { return velocity_; }

  /// Covariance of one component's error (p, v); pp * vv >= pv^2 up to rounding.
  struct Covariance {
    double pp = 0, pv = 0, vv = 0;
  };
  [[nodiscard]] std::array<Covariance, 3> angular_covariance() const;
  [[nodiscard]] std::array<Covariance, 3> linear_covariance() const;

  /// The same, factored: v's error is v_by_p times p's error, and one that has nothing to do with it. Every
  /// step adds positive terms only, so that no covariance is ever indefinite and none loses digits to a
  /// difference. Sources: G. J. Bierman, "Factorization methods for discrete sequential estimation", 1977 (U
  /// D U^T); C. L. Thornton, "Triangular covariance factorizations for Kalman filtering", 1976, for the step
  /// between measurements.
  struct Spread {
    double p = 0;        ///< variance of p
    double v_by_p = 0;   ///< 1/s
    double v_alone = 0;  ///< variance of v once p is known
  };

 private:
  KalmanTuning tuning_;
  HeadPose pose_;
  Twist velocity_;
  std::array<Spread, 3> angular_, linear_;
};

}  // namespace farshade
