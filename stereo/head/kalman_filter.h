/// The Kalman filter behind Predictor (prediction.h). It is started with a pose, stepped with poses, and
/// asked for the pose some seconds after the last one. It estimates a body twist, so that a head that turns
/// about its neck is extrapolated along that arc.
///
/// Every step solves its linear system exactly (damped_motion.h): any ratio of step to time constant is
/// valid, and so is a step of 0. Steps and leads are finite and not negative, poses are unit up to rounding,
/// constants are positive.
#pragma once

#include <array>

#include "stereo/math/twist.h"

namespace farshade {

using HeadPose = Rigid<Stage, Head>;

/// The motion model, for the axes of the head: x (pitch), y (yaw), z (roll).
struct KalmanTuning {
  glm::dvec3 angular_fade_s, linear_fade_s;  ///< time in which a velocity decays to 1/e; infinite: never
  double angular_drive, linear_drive;        ///< spectral density of the process noise, rad^2/s^3, m^2/s^3
  double angular_noise, linear_noise;        ///< standard deviation of a measured pose, rad, m
};

/// Error-state Kalman filter on SE(3). The state is a pose and a body twist. Each component of the twist is a
/// velocity that decays (damped_motion.h). Errors live in the tangent space at the estimate. The covariance
/// (not the pose) ignores the coupling of the components by the rotation within one step, so that it consists
/// of six 2 x 2 matrices.
/// Sources: J. Sola, "Quaternion kinematics for the error-state Kalman filter", 2017; S. Anderson, T. D.
/// Barfoot, "Full STEAM ahead: exactly sparse Gaussian process regression for batch continuous-time
/// trajectory estimation on SE(3)", IROS 2015, for the linear motion prior in the tangent space; R. A.
/// Singer, "Estimating optimal tracking filter performance for manned maneuvering targets", 1970, for the
/// decay.
class KalmanFilter {
 public:
  explicit KalmanFilter(const KalmanTuning& tuning) : tuning_(tuning) {}

  void start(const HeadPose& pose);
  void step(double step_s, const HeadPose& pose);
  [[nodiscard]] HeadPose ahead(double lead_s) const;
  [[nodiscard]] Twist velocity() const { return velocity_; }

  /// The covariance of the error (p, v) of one component, in factored form: the error of v is v_by_p times
  /// that of p, plus an independent error. Every step only adds positive terms, so that no covariance becomes
  /// indefinite or loses digits to cancellation. Sources: G. J. Bierman, "Factorization methods for discrete
  /// sequential estimation", 1977 (U D U^T); C. L. Thornton, "Triangular covariance factorizations for Kalman
  /// filtering", 1976, for the step between measurements.
  struct FactoredCovariance {
    double p = 0;        ///< variance of p
    double v_by_p = 0;   ///< 1/s
    double v_alone = 0;  ///< variance of v if p is known
  };
  [[nodiscard]] const std::array<FactoredCovariance, 3>& angular_covariance() const { return angular_; }
  [[nodiscard]] const std::array<FactoredCovariance, 3>& linear_covariance() const { return linear_; }

 private:
  KalmanTuning tuning_;
  HeadPose pose_;
  Twist velocity_;
  std::array<FactoredCovariance, 3> angular_, linear_;
};

}  // namespace farshade
