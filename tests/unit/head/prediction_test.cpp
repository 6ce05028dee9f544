#include "stereo/head/prediction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "tests/unit/head/screw.h"

namespace farshade {
namespace {

using std::chrono::milliseconds;
using std::numbers::pi;

static_assert(std::is_trivially_copyable_v<Predictor>, "a predictor is a value and owns no memory");

constexpr Duration kFrame = std::chrono::nanoseconds(13'888'889);

Time at_ms(std::int64_t ms) {
  return Time(milliseconds(ms));
}

HeadPose moved(const HeadPose& start, const Twist& twist, Duration after) {
  return start * motion_exp<Head>(twist * seconds_of(after));
}

bool is_finite(const HeadPose& pose) {
  return std::isfinite(glm::length(pose.translation)) && std::abs(glm::length(pose.rotation) - 1) < 1e-14;
}

/// The predictor says that the head stays at `pose`, whatever the lead.
void expect_held(const Predictor& predictor, const HeadPose& pose) {
  EXPECT_EQ(predictor.velocity(), Twist{});
  for (const int lead : {20, 50, 500})
    EXPECT_EQ(predictor.predict(*predictor.newest() + milliseconds(lead)), pose) << lead;
}

class PredictorOf : public testing::TestWithParam<PredictorKind> {
 protected:
  /// One second of a constant twist, with a pose per frame.
  [[nodiscard]] Predictor after_a_second(const HeadPose& start, const Twist& twist) const {
    Predictor predictor(GetParam());
    for (Duration now{}; now <= milliseconds(1000); now += kFrame)
      predictor.observe(Time(now), moved(start, twist, now));
    return predictor;
  }
};

INSTANTIATE_TEST_SUITE_P(Kind, PredictorOf, testing::ValuesIn(kPredictorKinds), [](const auto& instance) {
  std::string name;
  for (const char c : to_string(instance.param))
    if (c != '-') name += c;
  return name;
});

TEST_P(PredictorOf, NameReadsBack) {
  EXPECT_EQ(parse_predictor(to_string(GetParam())), GetParam());
  EXPECT_EQ(Predictor(GetParam()).newest(), std::nullopt);
}

TEST_P(PredictorOf, FollowsTheDirectionOfTheHead) {
  // Test both directions of every axis, from a head whose axes differ from the stage's. A predictor that
  // extrapolates backwards, or that confuses head axes and stage axes, is worse than one that holds the pose.
  const HeadPose start{rotation_exp({0.3, 2.0, -0.5}), {10, -3, 4}};
  for (int axis = 0; axis < 6; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      Twist twist;
      (axis < 3 ? twist.angular[axis] : twist.linear[axis - 3]) = sign;
      const Predictor predictor = after_a_second(start, twist);
      const Time later = *predictor.newest() + milliseconds(50);
      const HeadPose now = moved(start, twist, predictor.newest()->time_since_epoch());
      if (GetParam() == PredictorKind::Hold) {
        expect_held(predictor, now);
        continue;
      }
      const HeadPose then = moved(start, twist, later.time_since_epoch());
      EXPECT_LE(error_of(predictor.predict(later), then), 0.5 * error_of(now, then)) << axis << ' ' << sign;
      const Twist velocity = predictor.velocity();
      EXPECT_NEAR(axis < 3 ? velocity.angular[axis] : velocity.linear[axis - 3], sign, 0.1) << axis;
    }
}

TEST_P(PredictorOf, TurnsLeftAfterALeftTurn) {
  const Predictor predictor = after_a_second({}, {{0, 1, 0}, {}});
  const double heading = heading_rad(predictor.predict(*predictor.newest() + milliseconds(100)).rotation);
  const double now = seconds_of(predictor.newest()->time_since_epoch());
  if (GetParam() == PredictorKind::Hold) {
    EXPECT_NEAR(heading, now, 1e-14);
  } else {
    EXPECT_GT(heading, now + 0.08);
    EXPECT_LT(heading, now + 0.1 + 1e-9);
  }
}

TEST_P(PredictorOf, GivesTheNewestPoseBackBitForBit) {
  const Predictor predictor = after_a_second({rotation_exp({1, 2, 3}), {1e6, 2, 3}}, kScrew);
  const Time newest = *predictor.newest();
  const HeadPose seen = moved({rotation_exp({1, 2, 3}), {1e6, 2, 3}}, kScrew, newest.time_since_epoch());
  EXPECT_EQ(predictor.predict(newest), seen);
  EXPECT_EQ(predictor.predict(newest - milliseconds(50)), seen);
}

TEST_P(PredictorOf, LooksHalfASecondAheadAndNoFurther) {
  const Predictor predictor = after_a_second({}, kScrew);
  const HeadPose farthest = predictor.predict(*predictor.newest() + kFarthestLead);
  EXPECT_EQ(predictor.predict(*predictor.newest() + milliseconds(501)), farthest);
  EXPECT_EQ(predictor.predict(Time::max()), farthest);
  EXPECT_TRUE(is_finite(farthest));
}

TEST_P(PredictorOf, IgnoresRepeatedAndBackwardStamps) {
  const Predictor clean = after_a_second({}, kScrew);
  Predictor vexed(GetParam());
  for (Duration now{}; now <= milliseconds(1000); now += kFrame) {
    vexed.observe(Time(now), moved({}, kScrew, now));
    vexed.observe(Time(now), {rotation_exp({0, 3, 0}), {1, 1, 1}});
    vexed.observe(Time(now - milliseconds(30)), {rotation_exp({0, 0, 3}), {-1, 1, 1}});
  }
  for (const int lead : {0, 20, 100, 500}) {
    const Time later = *clean.newest() + milliseconds(lead);
    EXPECT_EQ(vexed.predict(later), clean.predict(later));
  }
}

TEST_P(PredictorOf, HoldsAfterALongGapAndPicksUpAgain) {
  Predictor predictor = after_a_second({}, kScrew);
  const Time back = *predictor.newest() + kLongestGap + kFrame;
  const HeadPose pose = moved({}, kScrew, back.time_since_epoch());
  predictor.observe(back, pose);
  EXPECT_EQ(predictor.velocity(), Twist{});
  EXPECT_LE(error_of(predictor.predict(back + milliseconds(100)), pose), 1e-15);
  for (int i = 1; i <= 10; ++i) {
    const Time time = back + i * kFrame;
    predictor.observe(time, moved({}, kScrew, time.time_since_epoch()));
  }
  if (GetParam() != PredictorKind::Hold) {
    EXPECT_NEAR(predictor.velocity().angular.y, kScrew.angular.y, 0.1);
  }
}

TEST_P(PredictorOf, KeepsGoingOverAShortGap) {
  Predictor predictor = after_a_second({}, kScrew);
  const Time back = *predictor.newest() + milliseconds(126);
  predictor.observe(back, moved({}, kScrew, back.time_since_epoch()));
  if (GetParam() == PredictorKind::Hold)
    return expect_held(predictor, moved({}, kScrew, back.time_since_epoch()));
  const Time later = back + milliseconds(50);
  const HeadPose then = moved({}, kScrew, later.time_since_epoch());
  EXPECT_LE(error_of(predictor.predict(later), then), 0.5 * error_of(predictor.predict(back), then));
}

TEST_P(PredictorOf, HoldsAHeadThatJumped) {
  for (const HeadPose& jump : {HeadPose{{1, 0, 0, 0}, {0, 0, 3}}, HeadPose{rotation_exp({0, pi, 0}), {}}}) {
    Predictor predictor = after_a_second({}, kScrew);
    predictor.observe(*predictor.newest() + kFrame, jump);
    EXPECT_EQ(predictor.velocity(), Twist{});
  }
  // The fastest head of the domain, 1,000 degrees/s, does not restart the filter.
  const Predictor fast = after_a_second({}, {{0, 1000 * pi / 180, 0}, {}});
  if (GetParam() != PredictorKind::Hold) {
    EXPECT_NEAR(fast.velocity().angular.y, 1000 * pi / 180, 1.0);
  }
}

/// By a controller, on displays of 60 to 120 Hz, while the head turns by 150 degrees/s to the other side.
TEST_P(PredictorOf, HoldsAHeadThatWasTurnedInAFrame) {
  for (const double rate_hz : {60.0, 72.0, 90.0, 120.0}) {
    const Duration frame = duration_from_ms(1e3 / rate_hz);
    Predictor predictor(GetParam());
    HeadPose head;
    Time now{};
    const auto show = [&](double turn_deg) {
      head = head * motion_exp<Head>(Twist{{0, turn_deg * pi / 180, 0}, {}});
      predictor.observe(now += frame, head);
    };
    for (int i = 0; i < 60; ++i) show(-150 / rate_hz);
    show(30 - 150 / rate_hz);
    EXPECT_EQ(predictor.velocity(), Twist{}) << rate_hz;
    const HeadPose then = predictor.predict(now + milliseconds(50));
    EXPECT_LT(angle_between_rad(then.rotation, head.rotation), 1e-12) << rate_hz;
  }
}

TEST_P(PredictorOf, KeepsItsVelocityOverJitterAndTheLongestGap) {
  // 0.03 rad and 3 cm within 0.1 ms are faster than any head, but still within jitter.
  Predictor jitter = after_a_second({}, kScrew);
  const HeadPose now = moved({}, kScrew, jitter.newest()->time_since_epoch());
  const HeadPose shaken = now * Rigid<Head, Head>{rotation_exp({0, 0.03, 0}), {0.03, 0, 0}};
  jitter.observe(*jitter.newest() + std::chrono::microseconds(100), shaken);
  Predictor gap = after_a_second({}, kScrew);
  const Time back = *gap.newest() + kLongestGap;
  const HeadPose after_gap = moved({}, kScrew, back.time_since_epoch());
  gap.observe(back, after_gap);
  if (GetParam() == PredictorKind::Hold) {
    expect_held(jitter, shaken);
    expect_held(gap, after_gap);
  } else {
    EXPECT_NE(jitter.velocity(), Twist{});
    EXPECT_NE(gap.velocity(), Twist{});
  }
}

TEST_P(PredictorOf, KeepsItsVelocityInABurst) {
  // A head that turns at 1 rad/s. Its poses are 0.1 ms apart and rounded to 1e-3, as in recordings.
  Predictor predictor(GetParam());
  for (int i = 0; i < 5000; ++i) {
    const double turn = std::round(1e-4 * i * 1e3) / 1e3;
    predictor.observe(Time(std::chrono::microseconds(100 * i)), {rotation_exp({0, turn, 0}), {}});
    ASSERT_LE(glm::length(predictor.velocity().angular), 2.0) << "pose " << i;
  }
}

TEST_P(PredictorOf, IsFiniteForAnyFiniteInput) {
  const unsigned seed = 77;
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::int64_t> any;
  std::uniform_int_distribution<int> exponent(-320, 308);
  std::uniform_real_distribution<double> turn(-4, 4), digits(-1, 1);
  const auto wild = [&] { return digits(random) * std::pow(10.0, exponent(random)); };
  Predictor predictor(GetParam());
  std::int64_t now = std::numeric_limits<std::int64_t>::min();
  for (int i = 0; i < 20000; ++i) {
    now += any(random) >> (i % 3 == 0 ? 62 : 36);  // 0 or 1 ns, or up to 0.13 s
    HeadPose pose{rotation_exp({turn(random), turn(random), turn(random)}), {wild(), wild(), wild()}};
    if (i % 5 == 0) pose.rotation = {wild(), wild(), wild(), wild()};
    predictor.observe(Time(Duration(now)), pose);
    ASSERT_TRUE(is_finite(predictor.predict(Time(Duration(now)) + milliseconds(i % 600)))) << "seed " << seed;
    ASSERT_TRUE(is_finite(predictor.predict(Time::max()))) << "seed " << seed;
  }
}

TEST_P(PredictorOf, IgnoresWhatIsNoPose) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  Predictor predictor(GetParam());
  predictor.observe(at_ms(0), {{nan, 0, 0, 1}, {}});
  predictor.observe(at_ms(0), {{0, 0, 0, 0}, {}});
  predictor.observe(at_ms(0), {{1, 0.2, 0, 0}, {}});
  predictor.observe(at_ms(0), {{1, 0, 0, 0}, {0, nan, 0}});
  predictor.observe(at_ms(0), {{1, 0, 0, 0}, {0, 0, -inf}});
  predictor.observe(at_ms(0), {{1, 0, 0, 0}, {2e9, 0, 0}});
  EXPECT_EQ(predictor.newest(), std::nullopt);
  predictor.observe(at_ms(0), {{1.001, 0, 0, 0}, {1, 2, 3}});
  EXPECT_EQ(predictor.predict(at_ms(0)), (HeadPose{{1, 0, 0, 0}, {1, 2, 3}}));
}

TEST_P(PredictorOf, DoesNotMindTheSignOfAQuaternion) {
  const Predictor clean = after_a_second({}, kScrew);
  Predictor flipped(GetParam());
  for (int i = 0; Time(i * kFrame) <= at_ms(1000); ++i) {
    HeadPose pose = moved({}, kScrew, i * kFrame);
    if (i % 2) pose.rotation = -pose.rotation;
    flipped.observe(Time(i * kFrame), pose);
  }
  const Time later = *clean.newest() + milliseconds(100);
  EXPECT_LE(error_of(flipped.predict(later), clean.predict(later)), 1e-9);
}

TEST(Predictor, KnowsNoOtherNames) {
  EXPECT_EQ(parse_predictor(""), std::nullopt);
  EXPECT_EQ(parse_predictor("Kalman"), std::nullopt);
}

TEST(Predictor, OfTheDefaultKindFadesOnTheScrewItWasOn) {
  // The prediction of a pure turn comes to a stop before the undamped one, and stays on the axis.
  Predictor predictor;
  for (int i = 0; i <= 72; ++i) predictor.observe(Time(i * kFrame), {rotation_exp({0, 0.02 * i, 0}), {}});
  const double rate = predictor.velocity().angular.y;
  EXPECT_NEAR(rate, 1.44, 0.02);
  double before = 1.44;
  for (int lead = 10; lead <= 500; lead += 10) {
    const glm::dquat said = predictor.predict(*predictor.newest() + milliseconds(lead)).rotation;
    const double heading = heading_rad(said);
    EXPECT_GT(heading, before);
    EXPECT_LE(heading, 1.44 + rate * lead * 1e-3);
    EXPECT_LE(angle_between_rad(said, rotation_exp({0, heading, 0})), 1e-12);
    before = heading;
  }
}

}  // namespace
}  // namespace farshade
