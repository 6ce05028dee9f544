#include "stereo/math/pose_filters.h"

#include "stereo/math/damped_motion.h"

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
  const Twist input = motion_between(pose_, pose) * (1.0 / step_s);
  const double x = step_s / smoothing_s_, once = x * mean_decay(x), both = twice_smoothed(x);
  // once - both = x e^-x, so each line is a weighted mean: no step overshoots.
  twice_ = twice_ * (1.0 - once) + once_ * (once - both) + input * both;
  once_ = once_ * (1.0 - once) + input * once;
  pose_ = pose;
}

HeadPose DoubleExponentialFilter::ahead(double lead_s) const {
  return carried(pose_, (twice_ - once_) * smoothing_s_ + twice_ * lead_s);
}

}  // namespace farshade
