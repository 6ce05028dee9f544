#include "vr_client/preview/headset_controls.h"

#include <gtest/gtest.h>

#include <limits>

#include "stereo/math/rotation.h"
#include "vr_client/preview/head.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr double kDegree_rad = std::numbers::pi / 180, kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kLeftHand = 0, kRightHand = 1;

/// Light 0 is 5 m ahead of the origin, light 1 is 5 m to the right.
LightSet lights_around() {
  LightSet set;
  set.lights.resize(2);
  set.lights[0].position = {{0, 0, -5}};
  set.lights[1].position = {{5, 0, 0}};
  set.lights[1].direction = {{0, -1, 0}};
  return set;
}

void expect_near(const glm::dvec3& actual, const glm::dvec3& expected, double tolerance = 1e-9) {
  EXPECT_LT(glm::length(actual - expected), tolerance)
      << "is " << actual.x << ", " << actual.y << ", " << actual.z << "; should be " << expected.x << ", "
      << expected.y << ", " << expected.z;
}

/// A viewer in a focused session, who has pressed nothing so far. Both hands are at the origin and point
/// along -z.
class HeadsetControlsTest : public testing::Test {
 protected:
  void SetUp() override {
    hands_.hand[kLeftHand].tracked_from_hand = hands_.hand[kRightHand].tracked_from_hand =
        Rigid<Tracked, Hand>{};
    show();
  }
  void show_with(const std::optional<Hands>& hands, Duration step = 10ms) {
    time_ += step;
    stage_from_tracked_ =
        follow_hands({time_, head_, stage_from_tracked_, hands}, state_, controls_, lights_);
  }
  /// One frame, `step` after the last one.
  void show(Duration step = 10ms) { show_with(hands_, step); }
  void show_for(Duration span, Duration step) {
    for (Duration shown{}; shown < span; shown += step) show(step);
  }
  void grab(std::size_t side) {
    hands_.hand[side].grab = 1;
    show();
  }
  void release(std::size_t side) {
    hands_.hand[side].grab = 0;
    show();
  }
  [[nodiscard]] Rigid<Stage, Head> stage_from_head() const { return stage_from_tracked_ * head_; }
  [[nodiscard]] bool holds(std::size_t side) const { return state_.grips[side].light.has_value(); }
  [[nodiscard]] LightSetRevision revision() const { return controls_.settings.lights.revision; }
  /// Where the viewer has moved the light that changed last.
  [[nodiscard]] LightPose moved() const {
    return controls_.settings.lights.lights.empty()
               ? LightPose{}
               : controls_.settings.lights.lights.back().pose.value_or(LightPose{});
  }

  LightSet lights_ = lights_around();
  Rigid<Tracked, Head> head_{{1, 0, 0, 0}, {0, 1.7, 0}};
  Rigid<Stage, Tracked> stage_from_tracked_;
  Hands hands_;
  ControllerState state_;
  Controls controls_;
  Time time_ = time_from_ns(1'000'000'000);
};

using HeadsetTurn = HeadsetControlsTest;
using HeadsetWalk = HeadsetControlsTest;
using HeadsetGrab = HeadsetControlsTest;
using HeadsetOverlay = HeadsetControlsTest;

TEST_F(HeadsetTurn, KeepsTheHeadWhereItIsAndLevel) {
  head_ = {rotation_exp({0.2, 0, 0}) * rotation_exp({0, 0.4, 0}), {1, 1.7, -2}};
  stage_from_tracked_ = {rotation_exp({0, 0.3, 0}), {10, 0.5, 3}};
  const Rigid<Stage, Head> before = stage_from_head();
  hands_.turn = 1;
  show();
  const Rigid<Stage, Head> after = stage_from_head();
  expect_near(after.translation, before.translation);
  EXPECT_NEAR(heading_rad(after.rotation), heading_rad(before.rotation) - 30 * kDegree_rad, 1e-9);
  expect_near(stage_from_tracked_.rotation * glm::dvec3(0, 1, 0), {0, 1, 0});
  EXPECT_GT(glm::length(stage_from_tracked_.translation - glm::dvec3(10, 0.5, 3)), 0.1)
      << "it does not turn around the origin of the tracked space";
}

TEST_F(HeadsetTurn, TurnsOnceForEachPush) {
  const auto turned_deg = [this] { return heading_rad(stage_from_head().rotation) / kDegree_rad; };
  hands_.turn = -0.6;
  show();
  EXPECT_NEAR(turned_deg(), 0, 1e-9) << "not pushed far enough";
  for (const double stick : {-0.8, -1.0, -0.5, -0.9}) {
    hands_.turn = stick;
    show();
    EXPECT_NEAR(turned_deg(), 30, 1e-9) << "to the left, at " << stick;
  }
  for (const double stick : {0.0, -1.0}) {
    hands_.turn = stick;
    show();
  }
  EXPECT_NEAR(turned_deg(), 60, 1e-9);
  for (const double stick : {0.0, 1.0}) {
    hands_.turn = stick;
    show();
  }
  EXPECT_NEAR(turned_deg(), 30, 1e-9) << "to the right";
}

TEST_F(HeadsetTurn, TwelveTurnsAreAWholeOne) {
  stage_from_tracked_ = {rotation_exp({0, 0.3, 0}), {10, 0.5, 3}};
  head_.translation = {1, 1.7, -2};
  const Rigid<Stage, Tracked> before = stage_from_tracked_;
  for (int push = 0; push < 12; ++push)
    for (const double stick : {1.0, 0.0}) {
      hands_.turn = stick;
      show();
    }
  EXPECT_LT(angle_between_rad(stage_from_tracked_.rotation, before.rotation), 1e-6);
  expect_near(stage_from_tracked_.translation, before.translation);
}

TEST_F(HeadsetWalk, WalksAheadOfTheHeadAtAnyFrameRate) {
  head_.rotation = rotation_exp({0, 90 * kDegree_rad, 0}) * rotation_exp({-60 * kDegree_rad, 0, 0});
  hands_.walk = {0, 1};
  for (const Duration step : {10ms, 20ms, 125ms}) {
    stage_from_tracked_ = {};
    show_for(1s, step);
    // To the left, level although the head looks down.
    expect_near(stage_from_tracked_.translation, {-kWalkingSpeed_m_per_s, 0, 0});
    expect_near(stage_from_tracked_.rotation * glm::dvec3(0, 0, -1), {0, 0, -1});
  }
}

TEST_F(HeadsetWalk, FollowsTheStick) {
  stage_from_tracked_.rotation = rotation_exp({0, -90 * kDegree_rad, 0});  // ahead is +x, right is +z
  const Rigid<Stage, Tracked> start = stage_from_tracked_;
  const auto walked = [&](const glm::dvec2& stick) {
    stage_from_tracked_ = start;
    hands_.walk = stick;
    show(100ms);
    return stage_from_tracked_.translation / (0.1 * kWalkingSpeed_m_per_s);
  };
  expect_near(walked({0, 1}), {1, 0, 0});
  expect_near(walked({0, -1}), {-1, 0, 0});
  expect_near(walked({1, 0}), {0, 0, 1});
  expect_near(walked({1, 1}), {std::numbers::sqrt2 / 2, 0, std::numbers::sqrt2 / 2});
  expect_near(walked({0, kDeadZone}), {0, 0, 0});
  expect_near(walked({-kDeadZone / 2, kDeadZone / 2}), {0, 0, 0});
  expect_near(walked({0, kDeadZone + 0.01}), {0.01 / (1 - kDeadZone), 0, 0});
  expect_near(walked({0, (1 + kDeadZone) / 2}), {0.5, 0, 0});
}

TEST_F(HeadsetWalk, DelayedFramesDoNotMoveFar) {
  hands_.walk = {0, 1};
  show(1h);
  expect_near(stage_from_tracked_.translation, {0, 0, -kWalkingSpeed_m_per_s * seconds_of(kLongestStep)});
  const Rigid<Stage, Tracked> before = stage_from_tracked_;
  show(-1s);
  EXPECT_EQ(stage_from_tracked_, before) << "a display time that goes back";
}

TEST_F(HeadsetWalk, FirstFrameOfAllDoesNotMove) {
  state_ = {};
  hands_.walk = {0, 1};
  show();
  EXPECT_EQ(stage_from_tracked_, (Rigid<Stage, Tracked>{}));
}

TEST_F(HeadsetWalk, WithoutInputTheViewerStandsBitForBit) {
  stage_from_tracked_ = {rotation_exp({0, 0.3, 0}), {0.1, 0.2, 0.3}};
  const Rigid<Stage, Tracked> before = stage_from_tracked_;
  show_for(1s, 11ms);
  EXPECT_EQ(stage_from_tracked_, before);
}

TEST_F(HeadsetWalk, HandThatHoldsNothingLeadsAhead) {
  hands_.hand[kLeftHand].tracked_from_hand->rotation =
      rotation_exp({0, 180 * kDegree_rad, 0}) * rotation_exp({50 * kDegree_rad, 0, 0});
  hands_.hand[kLeftHand].ahead = true;
  show(100ms);
  EXPECT_EQ(stage_from_tracked_.translation, glm::dvec3(0)) << "its button is not pressed";
  grab(kLeftHand);  // its light is behind it
  EXPECT_FALSE(holds(kLeftHand));
  stage_from_tracked_ = {};
  show(100ms);
  expect_near(stage_from_tracked_.translation, {0, 0, 0.1 * kWalkingSpeed_m_per_s});
  hands_.walk = {1, 0};
  stage_from_tracked_ = {};
  show(100ms);
  EXPECT_NEAR(glm::length(stage_from_tracked_.translation), 0.1 * kWalkingSpeed_m_per_s, 1e-9)
      << "stick and hand together are not faster";
  hands_.walk = {};
  hands_.hand[kLeftHand].tracked_from_hand.reset();
  const Rigid<Stage, Tracked> before = stage_from_tracked_;
  show(100ms);
  EXPECT_EQ(stage_from_tracked_, before) << "nobody knows where the hand points";
}

TEST_F(HeadsetWalk, HandThatHoldsALightDoesNotLead) {
  hands_.hand[kLeftHand].ahead = true;
  grab(kLeftHand);
  EXPECT_TRUE(holds(kLeftHand));
  show(100ms);
  EXPECT_EQ(stage_from_tracked_.translation, glm::dvec3(0));
}

TEST_F(HeadsetControlsTest, NumbersThatAreNotFiniteChangeNothing) {
  grab(kRightHand);
  ASSERT_TRUE(holds(kRightHand));
  const Rigid<Stage, Tracked> before = stage_from_tracked_;
  const LightSetRevision lights = revision();
  for (const double wrong : {kNan, std::numeric_limits<double>::infinity()}) {
    hands_.walk = {wrong, 1};
    hands_.turn = -wrong;
    hands_.hand[kRightHand].grab = -wrong;
    hands_.hand[kLeftHand].grab = wrong;
    hands_.hand[kRightHand].tracked_from_hand = Rigid<Tracked, Hand>{{1, 0, 0, 0}, {0, wrong, 0}};
    show();
    hands_.hand[kRightHand].tracked_from_hand = Rigid<Tracked, Hand>{{wrong, 0, 0, 0}, {1, 0, 0}};
    show();
  }
  EXPECT_EQ(stage_from_tracked_, before);
  EXPECT_EQ(revision(), lights);
  EXPECT_TRUE(holds(kRightHand));
  EXPECT_FALSE(holds(kLeftHand));
}

TEST_F(HeadsetGrab, LightMovesWithTheHand) {
  grab(kRightHand);
  EXPECT_EQ(revision(), next(kFirstLightSet)) << "the light is where it was, now as a change";
  expect_near(moved().position.v, {0, 0, -5});
  hands_.hand[kRightHand].tracked_from_hand = {rotation_exp({0, 90 * kDegree_rad, 0}), {1, 2, 3}};
  show();
  // The hand points along -x now.
  expect_near(moved().position.v, {1 - 5, 2, 3});
  expect_near(moved().direction.v, {-1, 0, 0});
  EXPECT_EQ(controls_.settings.lights.lights.back().light, 0u);
  const LightSetRevision before = revision();
  show();
  EXPECT_EQ(revision(), before) << "a hand that stands still makes no new light set";
  release(kRightHand);
  hands_.hand[kRightHand].tracked_from_hand = Rigid<Tracked, Hand>{};
  show();
  EXPECT_EQ(revision(), before);
  expect_near(moved().position.v, {-4, 2, 3});
}

TEST_F(HeadsetGrab, LightStaysInTheHandOfAViewerWhoWalksAndTurns) {
  grab(kRightHand);
  hands_.walk = {0.5, 1};
  hands_.turn = 1;
  show(100ms);
  const Rigid<Stage, Hand> stage_from_hand = stage_from_tracked_ * *hands_.hand[kRightHand].tracked_from_hand;
  EXPECT_GT(glm::length(stage_from_hand.translation), 0.1);
  expect_near(moved().position.v, stage_from_hand(Point<Hand>{{0, 0, -5}}).v);
}

TEST_F(HeadsetGrab, TakesTheLightNextToTheRay) {
  const auto takes = [this](const glm::dvec3& rotation) {
    hands_.hand[kLeftHand].tracked_from_hand->rotation = rotation_exp(rotation);
    grab(kLeftHand);
    const auto& light = state_.grips[kLeftHand].light;
    const int taken = light ? static_cast<int>(light->light) : -1;
    release(kLeftHand);
    return taken;
  };
  EXPECT_EQ(takes({0, 0, 0}), 0);
  EXPECT_EQ(takes({0, 9 * kDegree_rad, 0}), 0);
  EXPECT_EQ(takes({-9 * kDegree_rad, 0, 0}), 0);
  EXPECT_EQ(takes({0, 11 * kDegree_rad, 0}), -1);
  EXPECT_EQ(takes({11 * kDegree_rad, 0, 0}), -1);
  EXPECT_EQ(takes({0, 180 * kDegree_rad, 0}), -1) << "the light is behind the hand";
  EXPECT_EQ(takes({0, -90 * kDegree_rad, 0}), 1);
  EXPECT_EQ(controls_.light, 1u) << "it is the selected light now";
  lights_.lights[1].position = {{0.5, 0, -5}};
  EXPECT_EQ(takes({0, -1 * kDegree_rad, 0}), 0);
  EXPECT_EQ(takes({0, -5 * kDegree_rad, 0}), 1);
  lights_.lights[1].position = {{0, 0.01, kTouch_m / 2}};
  EXPECT_EQ(takes({0, 90 * kDegree_rad, 0}), 1) << "the hand touches it";
}

TEST_F(HeadsetGrab, TakesNoLightThatIsOffOrHasNoPlace) {
  lights_.lights[0].on = false;
  grab(kLeftHand);
  EXPECT_FALSE(holds(kLeftHand));
  release(kLeftHand);
  lights_.lights[0].on = true;
  lights_.lights[0].kind = LightKind::Directional;
  grab(kLeftHand);
  EXPECT_FALSE(holds(kLeftHand));
  release(kLeftHand);
  lights_.lights.clear();
  grab(kLeftHand);
  EXPECT_FALSE(holds(kLeftHand));
  EXPECT_EQ(revision(), kFirstLightSet);
}

TEST_F(HeadsetGrab, TriggerHasAHysteresis) {
  HandInput& hand = hands_.hand[kLeftHand];
  const auto holds_at = [&](double trigger) {
    hand.grab = trigger;
    show();
    return holds(kLeftHand);
  };
  EXPECT_FALSE(holds_at(0.5));
  EXPECT_TRUE(holds_at(0.6));
  EXPECT_TRUE(holds_at(0.5));
  EXPECT_FALSE(holds_at(0.4));
  EXPECT_FALSE(holds_at(0.5));
}

TEST_F(HeadsetGrab, PressTakesOnlyWhatTheHandPointsAtThen) {
  HandInput& hand = hands_.hand[kLeftHand];
  hand.tracked_from_hand->rotation = rotation_exp({0, 180 * kDegree_rad, 0});
  grab(kLeftHand);
  hand.tracked_from_hand = Rigid<Tracked, Hand>{};
  show();
  EXPECT_FALSE(holds(kLeftHand)) << "the hand sweeps over the light with its button pressed";
  release(kLeftHand);
  hand.tracked_from_hand.reset();
  grab(kLeftHand);
  hand.tracked_from_hand = Rigid<Tracked, Hand>{};
  show();
  EXPECT_FALSE(holds(kLeftHand)) << "the pose was unknown when the button was pressed";
}

TEST_F(HeadsetGrab, LightStaysWhileTheHandIsNotSeen) {
  HandInput& hand = hands_.hand[kRightHand];
  grab(kRightHand);
  hand.tracked_from_hand->translation = {0, 1, 0};
  show();
  const LightSetRevision before = revision();
  hand.tracked_from_hand.reset();
  show_for(1s, 10ms);
  EXPECT_TRUE(holds(kRightHand)) << "the button is pressed";
  EXPECT_EQ(revision(), before);
  hand.tracked_from_hand = {{1, 0, 0, 0}, {0, 2, 0}};
  show();
  expect_near(moved().position.v, {0, 2, -5});
  hand.tracked_from_hand.reset();
  release(kRightHand);
  hand.tracked_from_hand = Rigid<Tracked, Hand>{};
  show();
  EXPECT_FALSE(holds(kRightHand));
  expect_near(moved().position.v, {0, 2, -5});
}

TEST_F(HeadsetGrab, OneHandTakesTheLightOfTheOtherOrOfTheHead) {
  controls_.grab = hold(0, lights_.lights[0], stage_from_head());
  grab(kLeftHand);
  EXPECT_FALSE(controls_.grab);
  EXPECT_TRUE(holds(kLeftHand));
  controls_.grab = hold(1, lights_.lights[1], stage_from_head());
  grab(kRightHand);
  EXPECT_TRUE(controls_.grab) << "it is another light";
  EXPECT_TRUE(holds(kRightHand));
  EXPECT_FALSE(holds(kLeftHand));
  hands_.hand[kLeftHand].tracked_from_hand->translation = {0, 7, 0};
  show();
  expect_near(moved().position.v, {0, 0, -5});
  release(kRightHand);
  EXPECT_FALSE(holds(kLeftHand)) << "the other hand must press again";
}

TEST_F(HeadsetGrab, TwoHandsMoveTwoLights) {
  hands_.hand[kRightHand].tracked_from_hand->rotation = rotation_exp({0, -90 * kDegree_rad, 0});
  grab(kLeftHand);
  grab(kRightHand);
  hands_.hand[kLeftHand].tracked_from_hand->translation = {0, 1, 0};
  hands_.hand[kRightHand].tracked_from_hand->translation = {0, 2, 0};
  show();
  ASSERT_EQ(controls_.settings.lights.lights.size(), 2u);
  for (const LightChange& change : controls_.settings.lights.lights)
    expect_near(change.pose->position.v, change.light == 0 ? glm::dvec3(0, 1, -5) : glm::dvec3(5, 2, 0));
  expect_near(moved().direction.v, {0, -1, 0});
}

TEST_F(HeadsetControlsTest, WithoutFocusTheHandsLetGoAndNothingMoves) {
  grab(kRightHand);
  const LightSetRevision lights = revision();
  const Overlay overlay = controls_.overlay;
  hands_.walk = {0, 1};
  const Rigid<Stage, Tracked> before = stage_from_tracked_;
  show_with(std::nullopt);
  EXPECT_FALSE(holds(kRightHand));
  EXPECT_EQ(stage_from_tracked_, before);
  // Buttons that were pressed for another program.
  hands_.walk = {};
  hands_.turn = 1;
  hands_.next_overlay = true;
  hands_.hand[kLeftHand].grab = 1;
  hands_.hand[kLeftHand].ahead = true;
  show();
  show();
  EXPECT_EQ(stage_from_tracked_, before);
  EXPECT_EQ(revision(), lights);
  EXPECT_EQ(controls_.overlay, overlay);
  EXPECT_FALSE(holds(kLeftHand) || holds(kRightHand));
  hands_.turn = 0;
  hands_.next_overlay = false;
  release(kLeftHand);
  release(kRightHand);
  grab(kLeftHand);
  EXPECT_TRUE(holds(kLeftHand)) << "pressed again, it counts";
  hands_.turn = 1;
  hands_.next_overlay = true;
  show();
  EXPECT_NE(controls_.overlay, overlay);
  EXPECT_NEAR(heading_rad(stage_from_tracked_.rotation), -30 * kDegree_rad, 1e-9);
}

TEST_F(HeadsetOverlay, EachPressShowsTheNextOne) {
  const auto press = [this](bool pressed) {
    hands_.next_overlay = pressed;
    show();
    return controls_.overlay;
  };
  EXPECT_EQ(press(true), kOverlays[1]);
  EXPECT_EQ(press(true), kOverlays[1]) << "it is still pressed";
  EXPECT_EQ(press(false), kOverlays[1]);
  EXPECT_EQ(press(true), kOverlays[2]);
  controls_.overlay = kOverlays.back();  // chosen in the window
  press(false);
  EXPECT_EQ(press(true), Overlay::None);
}

}  // namespace
}  // namespace farshade
