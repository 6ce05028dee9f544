#include "stereo/head/kalman_filter.h"

#include <algorithm>

#include "stereo/head/damped_motion.h"

namespace farshade {
namespace {

using FactoredCovariance = KalmanFilter::FactoredCovariance;

// Standard deviation of the initial velocity (rad/s, m/s) is at most this, also for long decay times.
constexpr double kInitialSpeed = 1.0;

/// The corrections of p and v per unit of the measured error of p.
struct Gain {
  double p = 0, v = 0;
};

/// The covariance at the start: the velocity has the stationary variance of the process.
FactoredCovariance initial(double fade_s, double drive, double noise) {
  return {.p = noise * noise,
          .v_by_p = 0.0,
          .v_alone = std::min(0.5 * drive * fade_s, kInitialSpeed * kInitialSpeed)};
}

/// The covariance after a step without noise: p becomes p + travel * v, v becomes keep * v.
FactoredCovariance propagated(const FactoredCovariance& s, const DampedStep& step) {
  const double stretch = 1.0 + step.travel_s * s.v_by_p;
  const double p = s.p * stretch * stretch + step.travel_s * step.travel_s * s.v_alone;
  if (!(p > 0)) return {.p = 0, .v_by_p = 0, .v_alone = step.keep * step.keep * s.v_alone};
  return {.p = p,
          .v_by_p = step.keep * (s.v_by_p * (s.p / p) * stretch + step.travel_s * (s.v_alone / p)),
          .v_alone = step.keep * step.keep * s.v_alone * (s.p / p)};
}

/// The covariance that the process noise adds in a step.
FactoredCovariance noise_of(const DampedStep& step, double drive) {
  if (!(drive * step.pp > 0)) return {.p = 0, .v_by_p = 0, .v_alone = drive * step.vv};
  const double v_by_p = step.pv / step.pp;  // takes at most 3/4 of vv
  return {.p = drive * step.pp, .v_by_p = v_by_p, .v_alone = drive * (step.vv - v_by_p * step.pv)};
}

/// The covariance of the sum of two independent errors.
FactoredCovariance sum(const FactoredCovariance& a, const FactoredCovariance& b) {
  const double p = a.p + b.p, part = p > 0 ? b.p / p : 0.0, apart = b.v_by_p - a.v_by_p;
  return {.p = p,
          .v_by_p = a.v_by_p + part * apart,
          .v_alone = a.v_alone + b.v_alone + a.p * part * apart * apart};
}

/// Updates the covariance by a measurement of p. It tells nothing about the part of v that is independent of
/// p.
Gain measure(FactoredCovariance& s, double noise) {
  const double r = noise * noise, gain = s.p / (s.p + r);
  s.p = gain * r;
  return {.p = gain, .v = gain * s.v_by_p};
}

/// The distance that the decaying velocity covers, per component.
glm::dvec3 travel(const glm::dvec3& velocity, const glm::dvec3& fade_s, double lead_s) {
  glm::dvec3 distance;
  for (int i = 0; i < 3; ++i) distance[i] = velocity[i] * damped_travel_s(lead_s, fade_s[i]);
  return distance;
}

/// Predicts velocity and covariances of the angular or the linear components over a step.
void predict_all(std::array<FactoredCovariance, 3>& factored, glm::dvec3& velocity, const glm::dvec3& fade_s,
                 double drive, double step_s) {
  for (int i = 0; i < 3; ++i) {
    const DampedStep step = damped_step(step_s, fade_s[i]);
    FactoredCovariance& one = factored[static_cast<std::size_t>(i)];
    one = sum(propagated(one, step), noise_of(step, drive));
    velocity[i] *= step.keep;
  }
}

/// Corrects the velocity by the measured error of the pose. Returns the correction of the pose.
glm::dvec3 correct_all(std::array<FactoredCovariance, 3>& factored, glm::dvec3& velocity,
                       const glm::dvec3& error, double noise) {
  glm::dvec3 correction;
  for (int i = 0; i < 3; ++i) {
    const Gain gain = measure(factored[static_cast<std::size_t>(i)], noise);
    correction[i] = gain.p * error[i];
    velocity[i] += gain.v * error[i];
  }
  return correction;
}

}  // namespace

void KalmanFilter::start(const HeadPose& pose) {
  pose_ = pose;
  velocity_ = {};
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    angular_[at] = initial(tuning_.angular_fade_s[i], tuning_.angular_drive, tuning_.angular_noise);
    linear_[at] = initial(tuning_.linear_fade_s[i], tuning_.linear_drive, tuning_.linear_noise);
  }
}

void KalmanFilter::step(double step_s, const HeadPose& pose) {
  pose_ = ahead(step_s);
  predict_all(angular_, velocity_.angular, tuning_.angular_fade_s, tuning_.angular_drive, step_s);
  predict_all(linear_, velocity_.linear, tuning_.linear_fade_s, tuning_.linear_drive, step_s);

  const Twist error = motion_between(pose_, pose);
  const Twist correction{correct_all(angular_, velocity_.angular, error.angular, tuning_.angular_noise),
                         correct_all(linear_, velocity_.linear, error.linear, tuning_.linear_noise)};
  pose_ = pose_ * motion_exp<Head>(correction);
}

HeadPose KalmanFilter::ahead(double lead_s) const {
  return pose_ * motion_exp<Head>({travel(velocity_.angular, tuning_.angular_fade_s, lead_s),
                                   travel(velocity_.linear, tuning_.linear_fade_s, lead_s)});
}

}  // namespace farshade
