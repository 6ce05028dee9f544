#include "stereo/head/kalman_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "stereo/head/damped_motion.h"
#include "stereo/head/prediction.h"
#include "tests/unit/head/covariance.h"
#include "tests/unit/head/screw.h"

namespace farshade {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

KalmanTuning tuning_with_fade(double fade_s) {
  return {.angular_fade_s = glm::dvec3(fade_s),
          .linear_fade_s = glm::dvec3(fade_s),
          .angular_drive = 1,
          .linear_drive = 0.1,
          .angular_noise = 3e-4,
          .linear_noise = 3e-4};
}

HeadPose on_screw(double time_s) {
  const HeadPose start{rotation_exp({0.2, 1.0, 0.1}), {3, 1.7, -2}};
  return start * motion_exp<Head>(kScrew * time_s);
}

TEST(Kalman, ExtrapolatesAConstantTwistExactlyForAnySteps) {
  KalmanFilter filter(tuning_with_fade(kForever));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> step(1e-3, 0.03);
  filter.start(on_screw(0));
  double now = 0;
  for (int i = 0; i < 300; ++i) {
    const double step_s = step(random);
    now += step_s;
    filter.step(step_s, on_screw(now));
  }
  for (const double lead_s : {0.02, 0.05, 0.1, 0.2, 0.5}) {
    EXPECT_LE(error_of(filter.ahead(lead_s), on_screw(now + lead_s)), 1e-9);
    EXPECT_GE(error_of(filter.ahead(lead_s), on_screw(now - lead_s)), lead_s);
  }
  EXPECT_LE(glm::length(filter.velocity().angular - kScrew.angular), 1e-8);
  EXPECT_LE(glm::length(filter.velocity().linear - kScrew.linear), 1e-8);
}

struct Steps {
  double step_s, constant_s;
};
class Stiffness : public testing::TestWithParam<Steps> {};

std::vector<Steps> stiffness_sweep() {
  std::vector<Steps> all;
  for (const double step_s : {1e-4, 1e-3, 1.0 / 72, 0.126, 1.0})
    for (const double constant_s : {1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 1e3})
      all.push_back({step_s, constant_s});
  return all;
}

TEST_P(Stiffness, OfKalmanFadesLikeTheContinuousSolution) {
  // Predict the time of the same steps at once, without measurements: v constant (1 - e^-x), never more than
  // v * constant.
  const auto [step_s, constant_s] = GetParam();
  KalmanFilter filter(tuning_with_fade(constant_s));
  filter.start({});
  for (int i = 1; i <= 5; ++i) filter.step(0.014, {rotation_exp({0, 0.01 * i, 0}), {0, 0, -0.01 * i}});
  const Twist velocity = filter.velocity();
  const HeadPose now = filter.ahead(0), later = filter.ahead(step_s);
  const double x = step_s / constant_s;
  const double way_s = constant_s * -std::expm1(-x);
  EXPECT_LE(error_of(later, now * motion_exp<Head>(velocity * way_s)), 1e-14);
  EXPECT_LE(way_s, constant_s);
}

TEST_P(Stiffness, LeavesKalmanCovariancePositiveAndItsEstimateAtThePoses) {
  const auto [step_s, constant_s] = GetParam();
  KalmanFilter filter(tuning_with_fade(constant_s));
  filter.start({rotation_exp({0, 1, 0}), {}});
  std::mt19937 random(1);
  std::normal_distribution<double> jitter(0, 3e-4);
  for (int i = 1; i <= 2000; ++i) {
    // Gaps and bursts around the normal step.
    const double this_step_s = step_s * (i % 7 == 0 ? 1e-3 : i % 11 == 0 ? 10 : 1);
    const HeadPose pose{rotation_exp({jitter(random), 1 + jitter(random), 0}), {jitter(random), 0, 0}};
    filter.step(this_step_s, pose);
    for (const auto& covariances : {filter.angular_covariance(), filter.linear_covariance()})
      for (const auto& factored : covariances) {
        const Covariance c = expanded(factored);
        ASSERT_GT(c.pp, 0);
        ASSERT_LE(c.pp,
                  3e-4 * 3e-4 * (1 + 1e-12));  // the filter never states a smaller variance than the bound
        ASSERT_GT(c.vv, 0);
        ASSERT_GE(c.pp * c.vv, c.pv * c.pv * (1 - 1e-9)) << "step " << i;
      }
    ASSERT_LE(error_of(filter.ahead(0), pose), 0.01) << "step " << i;
    ASSERT_LE(error_of(filter.ahead(0.5), pose), 1.0) << "step " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Kalman, Stiffness, testing::ValuesIn(stiffness_sweep()));

TEST(Kalman, IsLeastSquaresWithoutProcessNoise) {
  // Without process noise and decay, the best estimate is the line through all poses (Gauss).
  KalmanTuning tuning = tuning_with_fade(1e12);
  tuning.angular_drive = tuning.linear_drive = 1e-14;
  KalmanFilter filter(tuning);
  std::mt19937 random(21);
  std::normal_distribution<double> jitter(0, tuning.linear_noise);
  double t_sum = 0, y_sum = 0, tt_sum = 0, ty_sum = 0;
  constexpr int kCount = 200;
  for (int i = 0; i < kCount; ++i) {
    const double t = 0.014 * i, y = 0.3 * t + jitter(random);
    const HeadPose pose{{1, 0, 0, 0}, {y, 0, 0}};
    i == 0 ? filter.start(pose) : filter.step(0.014, pose);
    t_sum += t, y_sum += y, tt_sum += t * t, ty_sum += t * y;
  }
  const double slope = (kCount * ty_sum - t_sum * y_sum) / (kCount * tt_sum - t_sum * t_sum);
  EXPECT_NEAR(filter.velocity().linear.x, slope, 1e-7);
  const double line_end = y_sum / kCount + slope * (0.014 * (kCount - 1) - t_sum / kCount);
  EXPECT_NEAR(filter.ahead(0).translation.x, line_end, 1e-7);
}

TEST(Kalman, ErrorsMatchTheStatedVariances) {
  // A walker that moves as the filter's own model says, with gaps. The squared errors divided by the stated
  // variances are 1 on average (Bar-Shalom, Li, Kirubarajan, "Estimation with applications to tracking and
  // navigation", 2001, 5.4).
  for (const double fade_s : {0.02, 0.3, 5.0}) {
    const unsigned seed = 4711;
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const KalmanTuning tuning = tuning_with_fade(fade_s);
    KalmanFilter filter(tuning);
    double p = 0, v = 0, p_over = 0, v_over = 0;
    filter.start({});
    constexpr int kCount = 100'000;
    for (int i = 0; i < kCount; ++i) {
      const double step_s = i % 10 == 0 ? 0.126 : 0.014;
      const DampedStep step = damped_step(step_s, fade_s);
      const double drive = std::sqrt(tuning.linear_drive), a = std::sqrt(step.pp) * normal(random);
      p += step.travel_s * v + drive * a;
      v = step.keep * v +
          drive * (step.pv / step.pp * a + std::sqrt(step.vv - step.pv * step.pv / step.pp) * normal(random));
      filter.step(step_s, {{1, 0, 0, 0}, {p + tuning.linear_noise * normal(random), 0, 0}});
      const Covariance said = expanded(filter.linear_covariance()[0]);
      p_over += std::pow(filter.ahead(0).translation.x - p, 2) / said.pp / kCount;
      v_over += std::pow(filter.velocity().linear.x - v, 2) / said.vv / kCount;
    }
    EXPECT_NEAR(p_over, 1.0, 0.03) << "seed " << seed << " fade " << fade_s;
    EXPECT_NEAR(v_over, 1.0, 0.03) << "seed " << seed << " fade " << fade_s;
  }
}

TEST(Kalman, PredictsWellAfterGapsOf126Ms) {
  // Recorded heads have such steps. Predictions right after one must still be better than holding the head.
  Predictor kalman(PredictorKind::Kalman);
  double now = 0;
  for (int i = 0; i < 200; ++i) {
    now += i % 20 == 19 ? 0.126 : 1.0 / 72;
    kalman.observe(Time(Duration(std::llround(now * 1e9))), on_screw(now));
    if (i < 10) continue;
    const double later = now + 0.1;
    const HeadPose said = kalman.predict(Time(Duration(std::llround(later * 1e9))));
    EXPECT_LE(error_of(said, on_screw(later)), 0.5 * error_of(on_screw(now), on_screw(later)))
        << "step " << i;
  }
}

}  // namespace
}  // namespace farshade
