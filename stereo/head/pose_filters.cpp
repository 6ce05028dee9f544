#include "stereo/head/pose_filters.h"

#include <cmath>

#include "stereo/head/damped_motion.h"

namespace farshade {
namespace {

HeadPose carried(const HeadPose& pose, const Twist& motion) {
  return pose * motion_exp<Head>(motion);
}

}  // namespace

void HoldFilter::step(double, const HeadPose& pose) {
  pose_ = pose;
}
HeadPose HoldFilter::ahead(double) const {
  return pose_;
}

void ConstantVelocityFilter::start(const HeadPose& pose) {
  *this = {};
  pose_ = reference_ = next_reference_ = pose;
}

void ConstantVelocityFilter::step(double step_s, const HeadPose& pose) {
  pose_ = pose;
  reference_age_s_ += step_s;
  next_reference_age_s_ += step_s;
  // The reference is the newest pose kept that is old enough; one more is kept to follow it.
  if (next_reference_age_s_ >= kBaseline_s) {
    reference_ = next_reference_;
    reference_age_s_ = next_reference_age_s_;
    next_reference_ = pose;
    next_reference_age_s_ = 0;
  }
  if (reference_age_s_ >= kBaseline_s)
    velocity_ = motion_between(reference_, pose) * (1.0 / reference_age_s_);
}

HeadPose ConstantVelocityFilter::ahead(double lead_s) const {
  return carried(pose_, velocity_ * lead_s);
}

void DoubleExponentialFilter::start(const HeadPose& pose) {
  pose_ = pose;
  once_ = twice_ = {};
}

void DoubleExponentialFilter::step(double step_s, const HeadPose& pose) {
  const Twist moved = motion_between(pose_, pose);
  const double x = step_s / smoothing_s_, once = mean_decay(x), twice = mean_lag(x);
  // The input is a rate of moved / step, weighed without dividing by a step that may be next to nothing. Only
  // what is to be gained is added: where all rates agree nothing changes, so that rounding piles up to no
  // drift however small x is. The weights of all three rates lie in 0..1: no step overshoots.
  twice_ = twice_ + (once_ - twice_) * (x * std::exp(-x)) +
           (moved * (twice / smoothing_s_) - twice_ * (x * twice));
  once_ = once_ + (moved * (once / smoothing_s_) - once_ * (x * once));
  pose_ = pose;
}

HeadPose DoubleExponentialFilter::ahead(double lead_s) const {
  return carried(pose_, (twice_ - once_) * smoothing_s_ + twice_ * lead_s);
}

}  // namespace farshade
