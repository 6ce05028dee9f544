#include <algorithm>
#include <cmath>

#include "stereo/math/damped_motion.h"
#include "stereo/math/pose_filters.h"

namespace farshade {
namespace {

using Covariance = KalmanFilter::Covariance;

// A head not yet seen moving is taken to move at most about this fast (rad/s, m/s), whatever a long fade time
// makes of its driving noise.
constexpr double kUnseenSpeed = 1.0;

/// How a measured error of p changes p and v.
struct Gain {
  double p = 0, v = 0;
};

/// Velocity unknown, as it is of a process that has long run.
Covariance unseen(double fade_s, double drive, double noise) {
  return {noise * noise, 0.0, std::min(0.5 * drive * fade_s, kUnseenSpeed * kUnseenSpeed)};
}

void grow(Covariance& c, const DampedStep& step, double drive) {
  const double pv = c.pv + step.travel_s * c.vv;
  c.pp += step.travel_s * (c.pv + pv) + drive * step.pp;
  c.pv = step.keep * pv + drive * step.pv;
  c.vv = step.keep * step.keep * c.vv + drive * step.vv;
}

Gain measure(Covariance& c, double noise) {
  const double r = noise * noise, seen = c.pp + r;
  const Gain gain{c.pp / seen, c.pv / seen};
  // Variance of v once p is known, and what not quite knowing p adds: positive terms only, unlike vv - gain
  // pv.
  const double known = c.pp > 0 ? std::max(0.0, c.vv - c.pv * c.pv / c.pp) : c.vv;
  const double not_quite = c.pp > 0 ? c.pv * (c.pv / c.pp) * (r / seen) : 0.0;
  c = {gain.p * r, gain.v * r, known + not_quite};
  return gain;
}

/// Where a fading velocity leads, per component.
glm::dvec3 travel(const glm::dvec3& velocity, const glm::dvec3& fade_s, double lead_s) {
  glm::dvec3 way;
  for (int i = 0; i < 3; ++i) way[i] = velocity[i] * damped_travel_s(lead_s, fade_s[i]);
  return way;
}

/// One component kind's velocity and covariances carried over a step.
void grow_all(std::array<Covariance, 3>& covariance, glm::dvec3& velocity, const glm::dvec3& fade_s,
              double drive, double step_s) {
  for (int i = 0; i < 3; ++i) {
    const DampedStep step = damped_step(step_s, fade_s[i]);
    grow(covariance[static_cast<std::size_t>(i)], step, drive);
    velocity[i] *= step.keep;
  }
}

/// Corrects the velocity by the error of the pose, and returns what corrects the pose.
glm::dvec3 correct_all(std::array<Covariance, 3>& covariance, glm::dvec3& velocity, const glm::dvec3& error,
                       double noise) {
  glm::dvec3 correction;
  for (int i = 0; i < 3; ++i) {
    const Gain gain = measure(covariance[static_cast<std::size_t>(i)], noise);
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
    angular_[at] = unseen(tuning_.angular_fade_s[i], tuning_.angular_drive, tuning_.angular_noise);
    linear_[at] = unseen(tuning_.linear_fade_s[i], tuning_.linear_drive, tuning_.linear_noise);
  }
}

void KalmanFilter::step(double step_s, const HeadPose& pose) {
  pose_ = ahead(step_s);
  grow_all(angular_, velocity_.angular, tuning_.angular_fade_s, tuning_.angular_drive, step_s);
  grow_all(linear_, velocity_.linear, tuning_.linear_fade_s, tuning_.linear_drive, step_s);

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
