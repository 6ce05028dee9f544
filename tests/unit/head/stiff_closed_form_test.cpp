#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stereo/head/kalman_filter.h"
#include "tests/unit/head/covariance.h"
#include "tests/unit/head/stiff_reference.h"
#include "tests/unit/head/stiff_sweep.h"

namespace farshade {
namespace {

using stiff::Real;

constexpr double kRounding = std::numeric_limits<double>::epsilon();

TEST(StiffFilters, AgreeWithTheirClosedFormsOverTheWholeGrid) {
  const std::vector<stiff::GridError> errors = stiff::all_stiff_errors();
  EXPECT_EQ(errors.size(), 3U + 2 * 4 + 1);
  for (const stiff::GridError& e : errors)
    EXPECT_LE(e.largest, e.bound) << e.filter << ", " << e.figure << ": step " << e.step_s
                                  << " s, time constant " << e.constant_s << " s";
}

TEST(StiffReference, IsTheKnownSolutionOfADampedStep) {
  for (const Real x : {1e-3L, 0.3L, 1.0L, 7.0L, 100.0L, 1e5L}) {
    const Real fade_s = 0.02L, step_s = x * fade_s;
    const stiff::DampedReference step = stiff::damped_reference(step_s, fade_s);
    const Real gone = -std::expm1(-x);
    EXPECT_NEAR(static_cast<double>(step.keep - std::exp(-x)), 0, 1e-18);
    EXPECT_NEAR(static_cast<double>(step.travel_s / (fade_s * gone)), 1, 1e-17);
    EXPECT_NEAR(static_cast<double>(step.vv / (0.5L * fade_s * -std::expm1(-2 * x))), 1, 1e-17);
    EXPECT_NEAR(static_cast<double>(step.pv / (0.5L * fade_s * fade_s * gone * gone)), 1, 1e-17);
    const Real factor = 2 * x - 3 + 4 * std::exp(-x) - std::exp(-2 * x);  // cancels like x^-3
    EXPECT_NEAR(static_cast<double>(step.pp / (0.5L * fade_s * fade_s * fade_s * factor)), 1,
                x < 0.01L ? 1e-8 : 1e-15);
  }
}

struct GridPoint {
  double step_s, constant_s;
};

std::vector<GridPoint> grid() {
  std::vector<GridPoint> all;
  const stiff::Grid whole = stiff::whole_grid(1);
  for (const double step_s : whole.steps_s)
    for (const double constant_s : whole.constants_s) all.push_back({step_s, constant_s});
  return all;
}

KalmanTuning tuning_of(double fade_s, double drive) {
  return {.angular_fade_s = glm::dvec3(fade_s),
          .linear_fade_s = glm::dvec3(fade_s),
          .angular_drive = drive,
          .linear_drive = drive,
          .angular_noise = 3e-4,
          .linear_noise = 3e-4};
}

TEST(Kalman, KnowsAVelocityAsExactlyAsTwoPosesDefineIt) {
  // Nothing drives or damps a velocity of variance 1. Two poses h apart, each of variance r, reduce this
  // variance to 2 r / (h^2 + 2 r). Computed as a difference of variances, it would be lost from h = 1e4
  // sqrt(r) on.
  KalmanTuning tuning = tuning_of(1e42, 1e-40);
  for (const double noise : {1e-6, 3e-4})
    for (double step_s = 1e-4; step_s < 2e3; step_s *= 10) {
      tuning.linear_noise = noise;
      KalmanFilter filter(tuning);
      filter.start({});
      filter.step(step_s, {});
      const double r = noise * noise, expected = 2 * r / (step_s * step_s + 2 * r);
      EXPECT_NEAR(expanded(filter.linear_covariance()[0]).vv, expected, 8 * kRounding * expected)
          << noise << ' ' << step_s;
    }
}

/// The largest estimated velocity on a ramp of 1 m/s after a long rest, minus 1.
double overshoot(double step_s, double fade_s, double drive) {
  KalmanFilter filter(tuning_of(fade_s, drive));
  filter.start({});
  for (int i = 0; i < 300; ++i) filter.step(step_s, {});
  double fastest = 0;
  for (int i = 1; i <= 1000; ++i) {
    filter.step(step_s, {{1, 0, 0, 0}, {step_s * i, 0, 0}});
    fastest = std::max(fastest, filter.velocity().linear.x);
  }
  return fastest - 1;
}

TEST(Kalman, OvershootsARampByNoMoreThanTheContinuousAndTheSparseOptimum) {
  // Without decay, and for steps that become ever shorter, the filter becomes that of Kalman and Bucy, v' +
  // sqrt(2) w v + w^2 p with w^4 = drive / (noise^2 step). It is damped by 1 / sqrt(2), so it overshoots by
  // e^-pi. For steps that become ever longer, its gain is 3 - sqrt(3) per step (the fixed point of the
  // covariances without noise).
  const double continuous = std::exp(-std::numbers::pi), sparse = 2 - std::numbers::sqrt3;
  EXPECT_NEAR(overshoot(1e-4, 1e9, 0.01), continuous, 1e-3);
  EXPECT_NEAR(overshoot(1.0, 1e9, 10.0), sparse, 1e-6);
  for (const double drive : {0.01, 0.1, 1.0, 10.0})
    for (const auto& [step_s, fade_s] : grid()) {
      const double over = overshoot(step_s, fade_s, drive);
      EXPECT_LE(over, sparse) << "step " << step_s << " s, fade " << fade_s << " s, drive " << drive;
      const double w = std::pow(drive / (9e-8 * step_s), 0.25);
      if (w * step_s < 0.05) {
        EXPECT_LE(over, continuous + 1e-3)
            << "step " << step_s << " s, fade " << fade_s << " s, drive " << drive;
      }
    }
}

}  // namespace
}  // namespace farshade
