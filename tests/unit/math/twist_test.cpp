#include "stereo/math/twist.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace farshade {
namespace {

using std::numbers::pi;
using Pose = Rigid<Stage, Head>;

glm::dvec3 random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

/// Motions with one turning angle: seeded axes and translations.
std::vector<Twist> motions(double angle) {
  std::mt19937 random(11);
  std::vector<Twist> all;
  for (int i = 0; i < 20; ++i)
    all.push_back({angle * glm::normalize(random_vector(random)), random_vector(random)});
  return all;
}

class MotionAngle : public testing::TestWithParam<double> {};

TEST_P(MotionAngle, SurvivesExpThenLog) {
  for (const Twist& motion : motions(GetParam())) {
    const Twist back = motion_log(motion_exp<Head>(motion));
    EXPECT_LE(glm::length(back.angular - motion.angular), 1e-14);
    EXPECT_LE(glm::length(back.linear - motion.linear), 1e-13 * glm::length(motion.linear));
  }
}

TEST_P(MotionAngle, IsTheSameInOneStepOrInMany) {
  constexpr int kSteps = 1024;  // each step is small, so it uses the series
  for (const Twist& motion : motions(GetParam())) {
    const auto once = motion_exp<Head>(motion), small = motion_exp<Head>(motion * (1.0 / kSteps));
    Rigid<Head, Head> many;
    for (int i = 0; i < kSteps; ++i) many = many * small;
    EXPECT_LE(angle_between_rad(once.rotation, many.rotation), 1e-12);
    EXPECT_LE(glm::length(once.translation - many.translation), 1e-12);
  }
}

// Both sides of the limit of the series, tiny angles, and angles near half a turn.
INSTANTIATE_TEST_SUITE_P(Motion, MotionAngle,
                         testing::Values(0.0, 1e-300, 1e-160, 1e-12, 1e-6, 1e-3, 0.1, 0.4999, 0.5001, 1.0,
                                         pi / 2, 3.0, pi - 1e-6));

TEST(MotionExp, WalksAQuarterCircle) {
  // Ahead (-z) while turning left by 90 degrees: a quarter of a circle whose centre lies to the left.
  const double radius = 2 / pi;
  const auto moved = motion_exp<Head>({{0, pi / 2, 0}, {0, 0, -1}});
  EXPECT_LE(glm::length(moved.translation - glm::dvec3(-radius, 0, -radius)), 1e-15);
  EXPECT_LE(angle_between_rad(moved.rotation, rotation_exp({0, pi / 2, 0})), 1e-15);
}

TEST(MotionExp, TurnsAHeadAboutItsNeck) {
  const Point<Head> neck{{0, -0.15, 0.1}};
  for (const double angle : {1e-9, 1e-3, 0.3, 2.0}) {
    const glm::dvec3 turn = angle * glm::normalize(glm::dvec3(0.3, 1.0, -0.2));
    const auto moved = motion_exp<Head>({turn, -glm::cross(turn, neck.v)});
    EXPECT_LE(length(moved(neck) - neck), 1e-16) << angle;
    EXPECT_GE(glm::length(moved.translation), 0.05 * angle) << angle;
  }
}

TEST(MotionBetween, LeadsFromOnePoseToTheOther) {
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const Pose a{rotation_exp(random_vector(random)), random_vector(random)};
    const Pose b{rotation_exp(random_vector(random)), random_vector(random)};
    const Pose there = a * motion_exp<Head>(motion_between(a, b));
    EXPECT_LE(angle_between_rad(there.rotation, b.rotation), 1e-14);
    EXPECT_LE(glm::length(there.translation - b.translation), 1e-13);
  }
}

TEST(MotionBetween, IsInTheHeadsOwnAxes) {
  const Pose facing_right{rotation_exp({0, -pi / 2, 0}), {5, 1.7, 2}};
  const Pose ahead{facing_right.rotation, {5.5, 1.7, 2}};
  const Twist motion = motion_between(facing_right, ahead);
  EXPECT_LE(glm::length(motion.linear - glm::dvec3(0, 0, -0.5)), 1e-15);
  EXPECT_EQ(motion.angular, glm::dvec3(0));
}

TEST(MotionBetween, LosesNothingFarFromTheOrigin) {
  const glm::dvec3 far{1e6, -1e6, 1e6};
  const Pose a{rotation_exp({0.4, 1.1, -0.2}), far}, b{a.rotation, far + glm::dvec3(0.25, 0, 0)};
  EXPECT_NEAR(glm::length(motion_between(a, b).linear), 0.25, 1e-15);
}

}  // namespace
}  // namespace farshade
