#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "stereo/head/prediction.h"
#include "tests/support/sanitized.h"
#include "tests/unit/head/covariance.h"

namespace farshade {
namespace {

using std::chrono::milliseconds;
using std::numbers::pi;

constexpr int kManySteps = kSanitized ? 1'000'000 : 10'000'000;

constexpr double kRounding = std::numeric_limits<double>::epsilon();
constexpr double kTiniest = std::numeric_limits<double>::denorm_min();
constexpr double kFastestHead_rad_s = 1000 * pi / 180;

KalmanTuning tuning_with_fade(double fade_s) {
  return {.angular_fade_s = glm::dvec3(fade_s),
          .linear_fade_s = glm::dvec3(fade_s),
          .angular_drive = 0.9,
          .linear_drive = 0.09,
          .angular_noise = 3e-4,
          .linear_noise = 3e-4};
}

/// All filters with the constants of the product, and Kalman filters with decay times at both ends of the
/// domain.
std::vector<PoseFilter> all_filters() {
  std::vector<PoseFilter> all;
  for (const PredictorKind kind : kPredictorKinds) all.push_back(make_filter(kind));
  for (const double fade_s : {1e-5, 1e3}) all.push_back(KalmanFilter(tuning_with_fade(fade_s)));
  return all;
}

void start(PoseFilter& filter, const HeadPose& pose) {
  std::visit([&](auto& f) { f.start(pose); }, filter);
}
void step(PoseFilter& filter, double step_s, const HeadPose& pose) {
  std::visit([&](auto& f) { f.step(step_s, pose); }, filter);
}
HeadPose ahead(const PoseFilter& filter, double lead_s) {
  return std::visit([&](const auto& f) { return f.ahead(lead_s); }, filter);
}
Twist velocity(const PoseFilter& filter) {
  return std::visit([](const auto& f) { return f.velocity(); }, filter);
}

bool is_pose(const HeadPose& pose) {
  return std::isfinite(glm::length(pose.translation)) &&
         std::abs(glm::length(pose.rotation) - 1) <= 4 * kRounding;
}

glm::dvec3 random_axis(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

class ManySteps : public testing::TestWithParam<PredictorKind> {};

TEST_P(ManySteps, LeaveEveryFilterOnTheUnitSphere) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> some(-0.1, 0.1);
  std::vector<Rigid<Head, Head>> motions;
  for (int i = 0; i < 1021; ++i)
    motions.push_back(
        motion_exp<Head>({some(random) * random_axis(random), some(random) * random_axis(random)}));
  PoseFilter filter = make_filter(GetParam());
  HeadPose pose;
  start(filter, pose);
  double worst = 0;
  for (int i = 0; i < kManySteps; ++i) {
    pose = pose * motions[static_cast<std::size_t>(i) % motions.size()];
    step(filter, i % 64 == 0 ? 1e-4 : 0.014, pose);
    if (i % 256) continue;
    for (const HeadPose& said : {pose, ahead(filter, 0), ahead(filter, 0.1)})
      worst = std::max(worst, std::abs(glm::length(said.rotation) - 1));
  }
  EXPECT_LE(worst, 2 * kRounding);
  EXPECT_TRUE(is_pose(ahead(filter, 0.5)));
}

INSTANTIATE_TEST_SUITE_P(Kind, ManySteps, testing::ValuesIn(kPredictorKinds));

TEST(ManyTurns, ComeFullCircle) {
  // The quaternion of a step is rounded once, by up to half an ulp of 1 in half of its angle. Each product is
  // rounded again, by at most one rounding per step.
  std::mt19937 random(3);
  const glm::dvec3 axis = random_axis(random);
  HeadPose pose{rotation_exp({0.3, -1.0, 0.2}), {}};
  const glm::dquat first = pose.rotation;
  const Rigid<Head, Head> little{rotation_exp(axis * (2 * pi / kManySteps)), {}};
  for (int i = 0; i < kManySteps; ++i) {
    if (i == kManySteps / 2) {
      EXPECT_NEAR(angle_between_rad(first, pose.rotation), pi, kManySteps * kRounding);
    }
    pose = pose * little;
  }
  EXPECT_LE(angle_between_rad(first, pose.rotation), kManySteps * kRounding);
  EXPECT_LE(std::abs(glm::length(pose.rotation) - 1), 2 * kRounding);
}

void expect_covariance(const Covariance& c, double noise, double step_s) {
  ASSERT_TRUE(std::isfinite(c.vv));
  ASSERT_GT(c.pp, 0);
  ASSERT_GT(c.vv, 0);
  ASSERT_LE(c.pp, noise * noise);  // the variance of a pose is never larger than that of a measurement
  ASSERT_GE(c.pp * c.vv, c.pv * c.pv * (1 - 8 * kRounding)) << "step " << step_s;
}

TEST(Kalman, CovarianceIsPositiveOverMillionsOfStepsOfAnyLength) {
  const unsigned seed = 1234;
  for (const double fade_s : {1e-5, 1e-2, 1e3}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> exponent(-12, 6);
    KalmanFilter filter(tuning_with_fade(fade_s));
    filter.start({});
    for (int i = 0; i < kManySteps / 10; ++i) {
      const double step_s = i % 1000 == 0 ? kTiniest : std::pow(10.0, exponent(random));
      filter.step(step_s, {});
      expect_covariance(expanded(filter.angular_covariance()[1]), 3e-4, step_s);
      expect_covariance(expanded(filter.linear_covariance()[2]), 3e-4, step_s);
      if (HasFatalFailure()) FAIL() << "seed " << seed << ", step " << i << ", fade " << fade_s;
    }
  }
}

TEST(StiffFilters, AreFiniteForNoStepAtAllAndForEndlessOnes) {
  for (PoseFilter& filter : all_filters()) {
    for (const double step_s : {0.0, kTiniest, 1e-310, 1e-160, 1e-100, 1e-9, 10.0, 1e6}) {
      start(filter, {});
      double turned = 0;
      for (int i = 0; i < 200; ++i) {
        turned += i % 3 == 0 ? 1e-3 : 0.0;  // a head that moves within no time, and a head that stands still
        step(filter, step_s, {rotation_exp({0, turned, 0}), {0, 0, turned}});
        if (i % 10 == 0) step(filter, 0.014, {rotation_exp({0, turned, 0}), {0, 0, turned}});
        for (const double lead_s : {0.0, kTiniest, 0.1, 0.5})
          ASSERT_TRUE(is_pose(ahead(filter, lead_s))) << "filter " << filter.index() << " step " << step_s;
        const Twist twist = velocity(filter);
        ASSERT_TRUE(std::isfinite(glm::length(twist.angular) + glm::length(twist.linear)))
            << "filter " << filter.index() << " step " << step_s;
      }
    }
  }
}

TEST(StiffFilters, ForgetWithinAStepOfTenThousandTimeConstants) {
  const double constant_s = 1e-5, step_s = 0.1;
  KalmanFilter kalman(tuning_with_fade(constant_s));
  for (int i = 0; i < 100; ++i) {
    const HeadPose pose{rotation_exp({0, i % 2 ? 1.0 : 0.0, 0}), {}};
    if (i == 0) {
      kalman.start(pose);
      continue;
    }
    kalman.step(step_s, pose);
    // A velocity that decays at once covers no distance.
    EXPECT_LE(angle_between_rad(kalman.ahead(0.5).rotation, kalman.ahead(0).rotation), constant_s / step_s);
  }
}

TEST(StiffFilters, TakeHalfTurnsBetweenPosesEitherWay) {
  // Rounding decides the direction of a rotation by half a turn. It must decide nothing else.
  for (PoseFilter& filter : all_filters())
    for (const double step_s : {1e-4, 0.014, 0.2}) {
      start(filter, {});
      for (int i = 1; i <= 100; ++i) {
        const double half = pi + (i % 4 - 1.5) * 1e-15;
        HeadPose pose{i % 2 ? rotation_exp({0, half, 0}) : glm::dquat(1, 0, 0, 0), {}};
        if (i % 3 == 0) pose.rotation = -pose.rotation;
        step(filter, step_s, pose);
        for (const double lead_s : {0.0, 0.05, 0.5}) ASSERT_TRUE(is_pose(ahead(filter, lead_s)));
        ASSERT_LE(glm::length(velocity(filter).angular), 2 * pi / step_s) << filter.index() << ' ' << step_s;
      }
    }
}

TEST(RotationLog, IsContinuousExceptAtTheHalfTurn) {
  std::mt19937 random(17);
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 axis = random_axis(random);
    for (const double short_of : {1e-3, 1e-6, 1e-9, 1e-12}) {
      const glm::dvec3 below = rotation_log(rotation_exp(axis * (pi - short_of)));
      EXPECT_LE(glm::length(below - axis * (pi - short_of)), 4e-15) << short_of;
      const glm::dvec3 beyond = rotation_log(rotation_exp(axis * (pi + short_of)));
      EXPECT_LE(glm::length(beyond + axis * (pi - short_of)), 4e-15) << short_of;
    }
    // An error of 1e-3 in the length of a quaternion changes neither axis nor angle.
    for (const double angle : {0.0, 1e-300, 1e-9, 1.0, pi - 1e-9})
      for (const double length : {0.999, 1.001})
        EXPECT_LE(glm::length(rotation_log(rotation_exp(axis * angle) * length) - axis * angle), 4e-15)
            << angle;
  }
}

/// The prediction of the default filter for lead_s ahead, after a second at `rate` rad/s about an oblique
/// axis, and its distance in degrees from the integral of its velocity, if each axis decays with its own
/// constant.
double apart_from_integral_deg(double rate, double lead_s) {
  const glm::dvec3 turn = rate * glm::normalize(glm::dvec3(1, 1, 1)), fade_s{0.1, 1.0, 0.08};
  PoseFilter filter = make_filter(PredictorKind::Kalman);
  start(filter, {});
  for (int i = 1; i <= 72; ++i) step(filter, 1.0 / 72, {rotation_exp(turn * (i / 72.0)), {}});
  glm::dvec3 fading = velocity(filter).angular;
  glm::dquat integral = ahead(filter, 0).rotation;
  constexpr int kParts = 20'000;
  for (int i = 0; i < kParts; ++i) {
    integral = glm::normalize(integral * rotation_exp(fading * (lead_s / kParts)));
    fading *= glm::exp(-lead_s / kParts / fade_s);
  }
  return angle_between_rad(integral, ahead(filter, lead_s).rotation) * 180 / pi;
}

TEST(Kalman, FadingPerAxisStaysNearTheIntegralOfItsVelocity) {
  // docs/prediction.md, "Limits", quotes these figures.
  EXPECT_NEAR(apart_from_integral_deg(100 * pi / 180, 0.1), 0.0, 0.05);
  EXPECT_NEAR(apart_from_integral_deg(300 * pi / 180, 0.1), 0.35, 0.05);
  EXPECT_NEAR(apart_from_integral_deg(1000 * pi / 180, 0.1), 3.8, 0.3);
  EXPECT_NEAR(apart_from_integral_deg(1000 * pi / 180, 0.5), 52, 3);
}

/// A head that turns at the domain's limit about changing axes, with the faults that a recording may have:
/// gaps of minutes, bursts, repeated and backward stamps, quaternions of either sign and off unit by 1e-3,
/// half turns.
class WildHead {
 public:
  explicit WildHead(unsigned seed) : random_(seed) {}

  struct Sight {
    Time time;
    HeadPose pose;
  };
  Sight next() {
    const int kind = std::uniform_int_distribution<int>(0, 99)(random_);
    const Duration step = kind < 2    ? Duration(std::chrono::minutes(3))
                          : kind < 10 ? Duration(std::chrono::microseconds(100))
                          : kind < 14 ? Duration(milliseconds(126))
                                      : Duration(13'888'889);
    now_ += step;
    axis_ = glm::normalize(axis_ + 0.1 * random_axis(random_));
    const double moving_s = std::min(seconds_of(step), 0.126);
    pose_ = pose_ *
            motion_exp<Head>(Twist{kFastestHead_rad_s * axis_, kFastestWay_m_s * axis_} * (0.999 * moving_s));
    if (kind == 20) pose_.rotation = pose_.rotation * glm::dquat(0, 0, 1, 0);
    HeadPose seen = pose_;
    seen.rotation = seen.rotation * (kind % 2 ? 1.001 : -0.999);
    if (kind >= 30 && kind < 36) return {now_ - milliseconds(5 * (kind - 30)), seen};
    return {now_, seen};
  }

 private:
  std::mt19937 random_;
  Time now_{};
  glm::dvec3 axis_{0, 1, 0};
  HeadPose pose_;
};

TEST(StiffFilters, PredictNoFurtherThanTheFastestHeadGoes) {
  const unsigned seed = 99;
  // The Kalman filter overshoots a head that reverses by up to 2 - sqrt(3) of the change.
  const double most = 1 + 2 * (2 - std::numbers::sqrt3);
  for (const PoseFilter& filter : all_filters()) {
    Predictor predictor(filter);
    WildHead head(seed);
    for (int i = 0; i < 5000; ++i) {
      const auto [time, seen] = head.next();
      predictor.observe(time, seen);
      const Time newest = *predictor.newest();
      const HeadPose now = predictor.predict(newest + Duration(1));
      for (const int lead_ms : {1, 20, 100, 250, 500}) {
        const HeadPose said = predictor.predict(newest + milliseconds(lead_ms));
        ASSERT_TRUE(is_pose(said)) << "seed " << seed << " pose " << i << " filter " << filter.index();
        ASSERT_LE(angle_between_rad(now.rotation, said.rotation), kFastestHead_rad_s * most * 1e-3 * lead_ms)
            << "seed " << seed << " pose " << i << " filter " << filter.index() << " lead " << lead_ms;
        ASSERT_LE(glm::length(said.translation - now.translation), kFastestWay_m_s * most * 1e-3 * lead_ms)
            << "seed " << seed << " pose " << i << " filter " << filter.index() << " lead " << lead_ms;
      }
      ASSERT_EQ(predictor.predict(newest + milliseconds(501)), predictor.predict(newest + milliseconds(500)));
    }
  }
}

}  // namespace
}  // namespace farshade
