#include "stereo/frame/pose_delta.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "stereo/math/rotation.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

/// Whether both poses are equal, bit for bit.
bool is_zero(const PoseDelta& delta) {
  return delta.angle_rad == 0 && delta.distance_m == 0;
}

class PoseDeltaOf : public testing::TestWithParam<double> {
 protected:
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  glm::dvec3 in_cube(double half) {
    return {between(-half, half), between(-half, half), between(-half, half)};
  }
  /// Poses `GetParam()` metres from the origin.
  View any_view() {
    return {{rotation_exp(in_cube(1.7)), glm::dvec3(0.6, -0.64, 0.48) * GetParam() + in_cube(2)},
            {-0.7, 0.8, 0.6, -0.5},
            {96, 64}};
  }
  std::mt19937_64 random_{9};  // the seed
};

TEST_P(PoseDeltaOf, TheSamePoseIsZeroToTheLastBit) {
  for (int i = 0; i < 1000; ++i) {
    const View view = any_view();
    View wider = view;
    wider.fov.left_rad -= 0.1;
    wider.size.width += 16;
    for (const View& traced : {view, wider}) {
      const PoseDelta delta = pose_delta(view, {}, traced, {});
      ASSERT_TRUE(is_zero(delta)) << "case " << i;
      const Rigid<Eye, Eye> identity;
      ASSERT_EQ(delta.traced_from_shown, identity) << "case " << i;
    }
  }
}

TEST_P(PoseDeltaOf, StatesAngleAndDistanceOfAKnownMotion) {
  for (int i = 0; i < 1000; ++i) {
    const View traced = any_view();
    const double angle = between(0, std::numbers::pi);
    const glm::dvec3 step = in_cube(0.5), axis = glm::normalize(in_cube(1));
    View shown = traced;
    shown.stage_from_eye.rotation =
        glm::normalize(traced.stage_from_eye.rotation * rotation_exp(axis * angle));
    shown.stage_from_eye.translation += step;
    const glm::dvec3 stepped = shown.stage_from_eye.translation - traced.stage_from_eye.translation;
    const PoseDelta delta = pose_delta(shown, {}, traced, {});
    ASSERT_NEAR(delta.angle_rad, angle, 1e-12) << "case " << i;
    ASSERT_NEAR(delta.distance_m, glm::length(stepped), 1e-15) << "case " << i;
    ASSERT_FALSE(is_zero(delta));
  }
}

/// The shader needs the transform of points, `traced_from_shown`, not the poses.
TEST_P(PoseDeltaOf, CarriesPointsWithoutLossFarFromTheOrigin) {
  for (int i = 0; i < 1000; ++i) {
    const View shown = any_view(), traced = any_view();
    const Point<Eye> p{in_cube(10)};
    // The exact computation, relative to the position of the shown eye: positions are subtracted first.
    const glm::dvec3 apart = shown.stage_from_eye.translation - traced.stage_from_eye.translation;
    const glm::dvec3 right =
        glm::conjugate(traced.stage_from_eye.rotation) * (shown.stage_from_eye.rotation * p.v + apart);
    const PoseDelta delta = pose_delta(shown, {}, traced, {});
    ASSERT_LT(glm::length(delta.traced_from_shown(p).v - right), 1e-13) << "case " << i;
  }
}

TEST_P(PoseDeltaOf, BackIsTheInverse) {
  const View a = any_view(), b = any_view();
  const PoseDelta there = pose_delta(a, {}, b, {}), back = pose_delta(b, {}, a, {});
  EXPECT_NEAR(there.angle_rad, back.angle_rad, 1e-15);
  EXPECT_EQ(there.distance_m, back.distance_m);
  const Point<Eye> p{{1, 2, -3}};
  EXPECT_LT(length(back.traced_from_shown(there.traced_from_shown(p)) - p), 1e-13);
}

INSTANTIATE_TEST_SUITE_P(OriginsAt_m, PoseDeltaOf, testing::Values(0.0, 1e6));

TEST(PoseDelta, StatesTurnsAndStepsSeparately) {
  View traced{{rotation_exp({0, 0.3, 0}), {1, 1.6, 0}}, {-0.7, 0.8, 0.6, -0.5}, {96, 64}}, shown = traced;
  shown.stage_from_eye.translation.x += 0.5;
  const PoseDelta step = pose_delta(shown, {}, traced, {});
  EXPECT_EQ(step.angle_rad, 0);
  EXPECT_EQ(step.distance_m, 0.5);
  EXPECT_FALSE(is_zero(step));
  shown = traced;
  shown.stage_from_eye.rotation = rotation_exp({0, 0.3 + 1e-9, 0});
  const PoseDelta turn = pose_delta(shown, {}, traced, {});
  EXPECT_NEAR(turn.angle_rad, 1e-9, 1e-15) << "small angles count, too";
  EXPECT_EQ(turn.distance_m, 0);
  EXPECT_FALSE(is_zero(turn));
}

TEST(PoseDelta, KeepsASmallStepFarFromTheOrigin) {
  constexpr double step_m = 1.0 / 1024;  // exact next to 1e6
  const View traced{{rotation_exp({0.4, -1.1, 0.2}), {1e6, -7e5, 3e5}}, {-0.7, 0.8, 0.6, -0.5}, {96, 64}};
  View shown = traced;
  shown.stage_from_eye.translation.y += step_m;
  EXPECT_NEAR(glm::length(pose_delta(shown, {}, traced, {}).traced_from_shown.translation), step_m, 1e-15);
}

TEST(PoseDelta, AgeIsShownMinusTracedTime) {
  const View view{{}, {-0.7, 0.8, 0.6, -0.5}, {96, 64}};
  EXPECT_EQ(pose_delta(view, Time(70ms), view, Time(50ms)).age, 20ms);
  EXPECT_EQ(pose_delta(view, Time(50ms), view, Time(70ms)).age, -20ms)
      << "the traced view is for a later time";
}

}  // namespace
}  // namespace farshade
