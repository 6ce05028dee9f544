#include "stereo/head/damped_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace farshade {
namespace {

struct Case {
  double step_s, fade_s;
};

/// Steps from 1e-4 to 1 s and fade times from 1e-5 to 1e3 s, each extended by a decade on both sides, and
/// some round values.
std::vector<Case> sweep() {
  std::vector<Case> all;
  for (double step = -5; step <= 1; step += 0.5)
    for (double fade = -6; fade <= 4; fade += 0.5) all.push_back({std::pow(10, step), std::pow(10, fade)});
  for (const double x : {0.25, 0.499, 0.501, 0.999, 1.001, 2.0}) all.push_back({0.014, 0.014 / x});
  return all;
}

void expect_close(double actual, double expected, double relative, const Case& at) {
  EXPECT_NEAR(actual, expected, relative * std::abs(expected))
      << "step " << at.step_s << " fade " << at.fade_s;
}

/// The effect of step `a`, then step `b`.
DampedStep compose(const DampedStep& a, const DampedStep& b) {
  const double pv = a.pv + b.travel_s * a.vv;
  return {.keep = a.keep * b.keep,
          .travel_s = a.travel_s + b.travel_s * a.keep,
          .pp = a.pp + b.travel_s * (a.pv + pv) + b.pp,
          .pv = b.keep * pv + b.pv,
          .vv = b.keep * b.keep * a.vv + b.vv};
}

TEST(DampedStep, IsTheSameInOneStepOrInTwo) {
  for (const Case& at : sweep()) {
    const DampedStep whole = damped_step(at.step_s, at.fade_s);
    const DampedStep parts =
        compose(damped_step(0.25 * at.step_s, at.fade_s), damped_step(0.75 * at.step_s, at.fade_s));
    EXPECT_NEAR(parts.keep, whole.keep, 1e-15);
    expect_close(parts.travel_s, whole.travel_s, 1e-14, at);
    expect_close(parts.vv, whole.vv, 1e-13, at);
    expect_close(parts.pv, whole.pv, 1e-13, at);
    expect_close(parts.pp, whole.pp, 1e-13, at);
  }
}

TEST(DampedStep, IsUndampedForShortStepsAndDiffusionForLongOnes) {
  for (const double fade_s : {1e-5, 1e-2, 1.0, 1e3}) {
    const double brief_s = 1e-9 * fade_s, long_s = 1e9 * fade_s;
    const DampedStep brief = damped_step(brief_s, fade_s), longer = damped_step(long_s, fade_s);
    const Case at{brief_s, fade_s};
    expect_close(brief.keep, 1.0, 1e-8, at);
    expect_close(brief.travel_s, brief_s, 1e-8, at);
    expect_close(brief.vv, brief_s, 1e-8, at);
    expect_close(brief.pv, brief_s * brief_s / 2, 1e-8, at);
    expect_close(brief.pp, brief_s * brief_s * brief_s / 3, 1e-8, at);
    EXPECT_EQ(longer.keep, 0.0);
    expect_close(longer.travel_s, fade_s, 1e-8, at);
    expect_close(longer.vv, fade_s / 2, 1e-8, at);
    expect_close(longer.pv, fade_s * fade_s / 2, 1e-8, at);
    expect_close(longer.pp, fade_s * fade_s * long_s, 1e-8, at);
  }
}

TEST(DampedStep, NeverOvershootsAndItsNoiseIsACovariance) {
  for (const Case& at : sweep()) {
    const DampedStep step = damped_step(at.step_s, at.fade_s);
    EXPECT_GE(step.keep, 0.0);
    EXPECT_LE(step.keep, 1.0);
    EXPECT_GT(step.travel_s, 0.0);
    EXPECT_LE(step.travel_s, std::min(at.step_s, at.fade_s));
    EXPECT_GT(step.pp * step.vv, step.pv * step.pv) << "step " << at.step_s << " fade " << at.fade_s;
  }
}

TEST(DampedStep, KeepsAVelocityThatNeverFades) {
  const DampedStep step = damped_step(0.5, std::numeric_limits<double>::infinity());
  EXPECT_EQ(step.keep, 1.0);
  EXPECT_EQ(step.travel_s, 0.5);
  EXPECT_DOUBLE_EQ(step.pp, 0.125 / 3);
}

TEST(MeanDecay, IsOneAtRestAndOneOverXFarOut) {
  EXPECT_EQ(mean_decay(0), 1.0);
  EXPECT_DOUBLE_EQ(mean_decay(1e-12), 1.0 - 0.5e-12);
  EXPECT_DOUBLE_EQ(mean_decay(1e5), 1e-5);
}

}  // namespace
}  // namespace farshade
