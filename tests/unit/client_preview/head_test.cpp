#include "vr_client/preview/head.h"

#include <gtest/gtest.h>

#include <random>

#include "stereo/math/rotation.h"
#include "vr_client/runtime/headset.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
constexpr double kPi = std::numbers::pi;
constexpr double kRightAngle_px = 512;

Rigid<Stage, Head> standing(double yaw_rad, double pitch_rad = 0, double roll_rad = 0) {
  return {rotation_exp({0, yaw_rad, 0}) * rotation_exp({pitch_rad, 0, 0}) * rotation_exp({0, 0, roll_rad}),
          {1, 1.6, 3}};
}

SimulatedHead moved(double yaw_rad, const HeadInput& input, Duration span) {
  SimulatedHead head(standing(yaw_rad));
  head.step(input, span);
  return head;
}

glm::dvec3 walked(double yaw_rad, const HeadInput& input, Duration span) {
  return moved(yaw_rad, input, span).stage_from_head().translation - standing(0).translation;
}

glm::dvec3 ahead_of(const SimulatedHead& head) {
  return head.stage_from_head().rotation * glm::dvec3(0, 0, -1);
}

void expect_near(const glm::dvec3& is, const glm::dvec3& expected, double tolerance) {
  EXPECT_LT(glm::length(is - expected), tolerance) << is.x << " " << is.y << " " << is.z << ", not "
                                                   << expected.x << " " << expected.y << " " << expected.z;
}

TEST(SimulatedHead, TurnsInTheDirectionOfTheMouse) {
  const auto looks = [](glm::dvec2 turn_px) { return ahead_of(moved(0, {.turn_px = turn_px}, 10ms)); };
  expect_near(looks({kRightAngle_px, 0}), {1, 0, 0}, 1e-12);
  expect_near(looks({-kRightAngle_px, 0}), {-1, 0, 0}, 1e-12);
  expect_near(looks({0, kRightAngle_px / 2}), {0, -std::sqrt(0.5), -std::sqrt(0.5)}, 1e-12);
  expect_near(looks({0, -kRightAngle_px / 2}), {0, std::sqrt(0.5), -std::sqrt(0.5)}, 1e-12);
}

TEST(SimulatedHead, TurnsWithoutRoll) {
  SimulatedHead head(standing(0));
  head.step({.turn_px = {123, 77}}, 10ms);
  const Rigid<Stage, Head> turned = head.stage_from_head();
  EXPECT_NEAR((turned.rotation * glm::dvec3(1, 0, 0)).y, 0, 1e-15);
  head.step({}, 1s);
  EXPECT_EQ(head.stage_from_head(), turned);
}

TEST(SimulatedHead, WalksInTheDirectionOfItsHeading) {
  struct Case {
    double yaw_rad;
    glm::dvec3 walk, expected;
  };
  for (const Case& c : {Case{0, {0, 0, -1}, {0, 0, -1}}, Case{0, {1, 0, 0}, {1, 0, 0}},
                        Case{0, {0, 1, 0}, {0, 1, 0}}, Case{kPi / 2, {0, 0, -1}, {-1, 0, 0}},
                        Case{kPi / 2, {1, 0, 0}, {0, 0, -1}}, Case{kPi / 2, {0, -1, 0}, {0, -1, 0}},
                        Case{kPi, {0, 0, 1}, {0, 0, -1}}, Case{0, {0.5, 0, 0}, {0.5, 0, 0}}})
    expect_near(walked(c.yaw_rad, {.walk = c.walk}, 200ms), 0.28 * c.expected, 1e-12);
}

TEST(SimulatedHead, StaysOnTheFloorHoweverSteeplyItLooks) {
  for (const double pitch_rad : {-1.5, -0.7, 0.7, 1.5}) {
    SimulatedHead head(standing(0, pitch_rad));
    head.step({.walk = {0, 0, -1}}, 100ms);
    expect_near(head.stage_from_head().translation, {1, 1.6, 2.86}, 1e-12);
    head.step({.walk = {0, 1, 0}}, 100ms);
    expect_near(head.stage_from_head().translation, {1, 1.74, 2.86}, 1e-12);
  }
}

TEST(SimulatedHead, RunsAndIsNotFasterDiagonally) {
  EXPECT_NEAR(glm::length(walked(0, {.walk = {0, 0, -1}, .speed = MoveSpeed::Run}, 100ms)), 0.4, 1e-12);
  EXPECT_NEAR(glm::length(walked(0, {.walk = {1, 0, -1}}, 100ms)), 0.14, 1e-12);
  EXPECT_NEAR(glm::length(walked(0, {.walk = {1, 1, -1}}, 100ms)), 0.14, 1e-12);
}

TEST(SimulatedHead, LimitsTheStepOfALateFrame) {
  EXPECT_EQ(walked(0, {.walk = {0, 0, -1}}, 10s), walked(0, {.walk = {0, 0, -1}}, 250ms));
  EXPECT_NEAR(glm::length(walked(0, {.walk = {0, 0, -1}}, 250ms)), 0.35, 1e-12);
}

TEST(SimulatedHead, DoesNotDependOnTheFrameRate) {
  constexpr HeadInput whole{.turn_px = {300, 60}, .walk = {0.3, 0.2, -0.9}, .speed = MoveSpeed::Run};
  const Rigid<Stage, Head> expected = moved(0.4, whole, 240ms).stage_from_head();
  for (const int frames : {2, 3, 24, 240}) {
    SimulatedHead head(standing(0.4));
    HeadInput part = whole;
    part.turn_px /= frames;
    for (int i = 0; i < frames; ++i) head.step(part, 240ms / frames);
    expect_near(head.stage_from_head().translation, expected.translation, 1e-9);
    EXPECT_LT(angle_between_rad(head.stage_from_head().rotation, expected.rotation), 1e-9) << frames;
  }
}

TEST(SimulatedHead, LimitsThePitch) {
  for (const double sign : {-1.0, 1.0}) {
    SimulatedHead head(standing(0.3));
    head.step({.turn_px = {0, -sign * 1e5}}, 10ms);
    const glm::dvec3 ahead = ahead_of(head);
    EXPECT_GT(sign * ahead.y, std::sin(89.8 / 180 * kPi));
    EXPECT_NEAR(std::atan2(-ahead.x, -ahead.z), 0.3, 1e-9) << "the heading is unchanged";
    head.step({.turn_px = {0, sign * kRightAngle_px}}, 10ms);
    EXPECT_NEAR(ahead_of(head).y, -sign * std::sin(0.1 / 180 * kPi), 1e-9)
        << "the movement beyond the limit is dropped";
  }
}

TEST(SimulatedHead, StartsAtThePoseWithoutRoll) {
  for (const double roll_rad : {0.0, 0.3, -1.2}) {
    const Rigid<Stage, Head> start = standing(2.5, -0.6, roll_rad);
    const SimulatedHead head(start);
    EXPECT_EQ(head.stage_from_head().translation, start.translation);
    EXPECT_LT(angle_between_rad(head.stage_from_head().rotation, standing(2.5, -0.6).rotation), 1e-12);
  }
}

TEST(SimulatedHead, StartsLookingStraightUpOrDown) {
  for (const double pitch_rad : {-kPi / 2, kPi / 2}) {
    const SimulatedHead head(standing(1.1, pitch_rad));
    EXPECT_LT(angle_between_rad(head.stage_from_head().rotation, standing(1.1, pitch_rad).rotation), 0.002);
    EXPECT_NEAR(heading_rad(head.stage_from_head().rotation), 1.1, 1e-6);
  }
}

TEST(SimulatedHead, KeepsAUnitQuaternionForAMillionSteps) {
  constexpr unsigned seed = 4711;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-40, 40);
  SimulatedHead head(standing(0));
  double turned_px = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const glm::dvec2 turn_px(any(random), any(random));
    turned_px += turn_px.x;
    head.step({.turn_px = turn_px}, 1ms);
  }
  const Rigid<Stage, Head> end = head.stage_from_head();
  EXPECT_NEAR(glm::length(end.rotation), 1, 1e-15);
  EXPECT_EQ(end.translation, standing(0).translation);
  EXPECT_NEAR(std::remainder(heading_rad(end.rotation) + turned_px * kTurn_rad_per_px, 2 * kPi), 0, 1e-6);
}

TEST(SimulatedHeadDeathTest, RefusesInvalidInput) {
  SimulatedHead head(standing(0));
  EXPECT_DEATH(head.step({.turn_px = {NAN, 0}}, 1ms), "finite input");
  EXPECT_DEATH(head.step({.walk = {0, 0, INFINITY}}, 1ms), "finite input");
  EXPECT_DEATH(head.step({}, -1ms), "a span of at least 0");
}

TEST(HeadsetViews, EyesAreOneEyeDistanceApartAndParallel) {
  const Headset headset{.eye_distance_m = 0.08,
                        .fov = {EyeFov{-0.9, 0.7, 0.6, -0.5}, EyeFov{-0.7, 0.9, 0.6, -0.5}},
                        .eye_size = {96, 64}};
  const StereoView views = views_of(standing(kPi / 2), headset);
  expect_near(views[0].stage_from_eye.translation, {1, 1.6, 3.04}, 1e-12);
  expect_near(views[1].stage_from_eye.translation, {1, 1.6, 2.96}, 1e-12);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EXPECT_EQ(views[eye].fov, headset.fov[eye]);
    EXPECT_EQ(views[eye].size, headset.eye_size);
    EXPECT_LT(angle_between_rad(views[eye].stage_from_eye.rotation, standing(kPi / 2).rotation), 1e-12);
  }
}

TEST(HeadsetViews, CoincideAtEyeDistanceZero) {
  const EyeFov fov = field_of_view(1.5, 1);
  const StereoView views =
      views_of(standing(0.2), {.eye_distance_m = 0, .fov = {fov, fov}, .eye_size = {8, 8}});
  EXPECT_EQ(views[0], views[1]);
}

TEST(FieldOfView, IsSymmetricWithSquarePixels) {
  for (const double degrees : {1.0, 20.0, 90.0, 140.0})
    for (const double aspect : {0.5, 1.0, 1.6}) {
      const EyeFov fov = field_of_view(degrees / 180 * kPi, aspect);
      EXPECT_NEAR(fov.up_rad * 2, degrees / 180 * kPi, 1e-12);
      EXPECT_EQ(fov.up_rad, -fov.down_rad);
      EXPECT_EQ(fov.right_rad, -fov.left_rad);
      EXPECT_NEAR(std::tan(fov.right_rad) / std::tan(fov.up_rad), aspect, 1e-9);
    }
}

TEST(FieldOfView, StaysWithin1To170Degrees) {
  const auto degrees = [](double angle_rad) { return 2 * angle_rad / kPi * 180; };
  EXPECT_NEAR(degrees(field_of_view(0, 1).up_rad), 1, 1e-9);
  EXPECT_NEAR(degrees(field_of_view(-2, 1).up_rad), 1, 1e-9);
  EXPECT_NEAR(degrees(field_of_view(9, 1).up_rad), 170, 1e-9);
  EXPECT_NEAR(degrees(field_of_view(9, 0.25).up_rad), 170, 1e-9);
  for (const double aspect : {1.0, 2.0, 16.0}) {
    const EyeFov wide = field_of_view(9, aspect);
    EXPECT_NEAR(degrees(wide.right_rad), 170, 1e-9) << aspect;
    EXPECT_NEAR(std::tan(wide.right_rad) / std::tan(wide.up_rad), aspect, 1e-9);
    EXPECT_TRUE(is_valid(wide));
  }
}

TEST(FieldOfViewDeathTest, RefusesInvalidAspects) {
  EXPECT_DEATH((void)field_of_view(1, 0), "shape");
  EXPECT_DEATH((void)field_of_view(NAN, 1), "shape");
}

}  // namespace
}  // namespace farshade
