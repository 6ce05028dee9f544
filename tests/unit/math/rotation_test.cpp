#include "stereo/math/rotation.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace farshade {
namespace {

using std::numbers::pi;

/// Unit vectors: the axes, and seeded ones.
std::vector<glm::dvec3> axes() {
  std::vector<glm::dvec3> all{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20; ++i)
    all.push_back(glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))));
  return all;
}

class RotationAngle : public testing::TestWithParam<double> {};

TEST_P(RotationAngle, SurvivesExpThenLog) {
  const double angle = GetParam();
  for (const glm::dvec3& axis : axes()) {
    const glm::dvec3 there_and_back = rotation_log(rotation_exp(axis * angle));
    EXPECT_LE(glm::length(there_and_back - axis * angle), 1e-14 + 4e-16 * angle) << "angle " << angle;
    if (angle > 0 && angle < 1e-3) {
      EXPECT_LE(glm::length(there_and_back - axis * angle), 1e-12 * angle) << "angle " << angle;
    }
  }
}

TEST_P(RotationAngle, IsWhatAngleBetweenMeasures) {
  const double angle = GetParam();
  for (const glm::dvec3& axis : axes()) {
    const glm::dquat from = rotation_exp({0.3, -1.2, 0.7});
    EXPECT_NEAR(angle_between_rad(from, from * rotation_exp(axis * angle)), angle, 1e-14);
  }
}

// Both sides of the limits of the series, tiny angles, and angles near half a turn.
INSTANTIATE_TEST_SUITE_P(Rotation, RotationAngle,
                         testing::Values(0.0, 1e-300, 1e-160, 1e-12, 1e-8, 9.9e-5, 1.01e-4, 0.1, 1.0, pi / 2,
                                         3.0, pi - 1e-6, pi - 1e-9));

TEST(RotationExp, TurnsCounterClockwiseAboutItsAxis) {
  const glm::dvec3 turned = rotation_exp({0, pi / 2, 0}) * glm::dvec3(0, 0, -1);
  EXPECT_LE(glm::length(turned - glm::dvec3(-1, 0, 0)), 1e-15);
}

TEST(RotationLog, TakesTheShorterWayForEitherSign) {
  const glm::dquat q = rotation_exp({0, 0.5, 0});
  EXPECT_LE(glm::length(rotation_log(-q) - glm::dvec3(0, 0.5, 0)), 1e-15);
  const glm::dquat beyond_half_turn = rotation_exp({0, pi + 0.5, 0});
  EXPECT_LE(glm::length(rotation_log(beyond_half_turn) - glm::dvec3(0, 0.5 - pi, 0)), 1e-15);
}

TEST(RotationLog, IsHalfTurnLongForHalfTurns) {
  EXPECT_DOUBLE_EQ(glm::length(rotation_log(glm::dquat(0, 1, 0, 0))), pi);
  EXPECT_DOUBLE_EQ(glm::length(rotation_log(glm::dquat(-1e-17, 0, 1, 0))), pi);
}

TEST(Slerp, MeetsBothEndsAndTurnsAtConstantSpeed) {
  const glm::dquat a = rotation_exp({0.2, 0.1, -0.4}), b = rotation_exp({-1.0, 0.9, 0.3});
  const double whole = angle_between_rad(a, b);
  EXPECT_LE(angle_between_rad(slerp(a, b, 0), a), 1e-15);
  EXPECT_LE(angle_between_rad(slerp(a, b, 1), b), 1e-15);
  for (const double t : {0.1, 0.5, 0.75, 1.25})
    EXPECT_NEAR(angle_between_rad(a, slerp(a, b, t)), t * whole, 1e-14);
}

TEST(Slerp, IgnoresTheSignOfAQuaternion) {
  const glm::dquat a = rotation_exp({0.2, 0.1, -0.4}), b = rotation_exp({-1.0, 0.9, 0.3});
  EXPECT_LE(angle_between_rad(slerp(a, b, 0.3), slerp(-a, b, 0.3)), 1e-15);
  EXPECT_LE(angle_between_rad(slerp(a, b, 0.3), slerp(a, -b, 0.3)), 1e-15);
}

TEST(Slerp, KeepsRotationsTooCloseToTell) {
  const glm::dquat a = rotation_exp({0.2, 0.1, -0.4}), b = a * rotation_exp({1e-12, 0, 0});
  EXPECT_NEAR(angle_between_rad(a, slerp(a, b, 0.5)), 0.5e-12, 1e-15);
  EXPECT_DOUBLE_EQ(glm::length(slerp(a, a, 0.5)), 1.0);
}

TEST(Heading, IsAngleAboutUp) {
  EXPECT_DOUBLE_EQ(heading_rad(glm::dquat(1, 0, 0, 0)), 0);
  EXPECT_NEAR(heading_rad(rotation_exp({0, 0.7, 0})), 0.7, 1e-15);
  EXPECT_NEAR(heading_rad(rotation_exp({0, -3.0, 0})), -3.0, 1e-15);
}

TEST(Heading, IgnoresPitchAndRoll) {
  const glm::dquat tilted = rotation_exp({0, 0.7, 0}) * rotation_exp({1.2, 0, 0}) * rotation_exp({0, 0, 0.4});
  EXPECT_NEAR(heading_rad(tilted), 0.7, 1e-14);
}

TEST(Heading, StaysWhenLookingStraightUpOrDown) {
  for (const double pitch : {pi / 2, -pi / 2})
    EXPECT_NEAR(heading_rad(rotation_exp({0, 0.7, 0}) * rotation_exp({pitch, 0, 0})), 0.7, 1e-9) << pitch;
}

TEST(Interpolate, MovesPositionAndRotationTogether) {
  const Rigid<Stage, Head> a{rotation_exp({0, 0, 0}), {1, 2, 3}}, b{rotation_exp({0, 1, 0}), {3, 2, -1}};
  const auto middle = interpolate(a, b, 0.5);
  EXPECT_LE(glm::length(middle.translation - glm::dvec3(2, 2, 1)), 1e-15);
  EXPECT_LE(angle_between_rad(middle.rotation, rotation_exp({0, 0.5, 0})), 1e-15);
}

}  // namespace
}  // namespace farshade
