#include "vr_client/preview/controls.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

namespace farshade {
namespace {

using namespace std::chrono_literals;

LightSet two_lights() {
  LightSet set;
  set.lights.resize(2);
  set.lights[0].position = {{1, 2, 3}};
  set.lights[0].direction = {{0, -1, 0}};
  set.lights[1].position = {{-4, 2, 0}};
  return set;
}

class ControlsTest : public testing::Test {
 protected:
  ControlState stand() { return {lights_, head_, &player_}; }
  void act(Act what, int times = 1) {
    for (int i = 0; i < times; ++i) farshade::act(what, controls_, stand());
  }
  const LightChange& last_change() { return controls_.steering.lights.lights.back(); }

  LightSet lights_ = two_lights();
  Rigid<Stage, Head> head_;
  Player player_{10s};
  Controls controls_;
};

TEST(KeyBindings, NameEachKeyOnceAndReachEveryAct) {
  std::set<Key> keys;
  std::set<Act> acts;
  std::set<std::string> names;
  for (const KeyBinding& binding : key_bindings()) {
    EXPECT_TRUE(keys.insert(binding.key).second) << name_of(binding.key);
    EXPECT_TRUE(names.insert(name_of(binding.key)).second) << name_of(binding.key);
    acts.insert(binding.act);
    EXPECT_STRNE(binding.does, "");
  }
  EXPECT_EQ(acts.size(), kActs);
  for (const Key walks : {Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E}) EXPECT_FALSE(keys.contains(walks));
}

TEST(KeyNames, AreAsOnTheKeyboard) {
  EXPECT_EQ(name_of(Key::A), "A");
  EXPECT_EQ(name_of(Key::Z), "Z");
  EXPECT_EQ(name_of(Key::Digit0), "0");
  EXPECT_EQ(name_of(Key::F12), "F12");
  EXPECT_EQ(name_of(Key::Space), "Space");
  EXPECT_EQ(name_of(Key::Control), "Ctrl");
}

TEST_F(ControlsTest, LooksAndOverlaysGoRound) {
  std::set<Look> looks;
  for (std::size_t i = 0; i < kLooks.size(); ++i, act(Act::NextLook)) looks.insert(controls_.look);
  EXPECT_EQ(looks.size(), kLooks.size());
  EXPECT_EQ(controls_.look, Look::SideBySide);
  std::set<Overlay> overlays;
  for (std::size_t i = 0; i < kOverlays.size(); ++i, act(Act::NextOverlay))
    overlays.insert(controls_.overlay);
  EXPECT_EQ(overlays.size(), kOverlays.size());
  act(Act::NextOverlay, 3);
  act(Act::NoOverlay);
  EXPECT_EQ(controls_.overlay, Overlay::None);
}

TEST_F(ControlsTest, ReprojectionGuardBandAndPredictorsSteerTheSession) {
  act(Act::Reprojection);
  EXPECT_EQ(controls_.steering.carry_over.lookup, Lookup::Direct);
  act(Act::Reprojection);
  EXPECT_EQ(controls_.steering.carry_over.lookup, Lookup::Reproject);
  act(Act::GuardBand);
  EXPECT_EQ(controls_.steering.wish.guard_band, GuardBandUse::Off);
  std::set<PredictorKind> predictors;
  for (std::size_t i = 0; i < std::size(kPredictorKinds); ++i, act(Act::NextPredictor))
    predictors.insert(controls_.steering.wish.predictor);
  EXPECT_EQ(predictors.size(), std::size(kPredictorKinds));
  EXPECT_EQ(controls_.steering.wish.predictor, kDefaultPredictor);
  act(Act::Animation);
  EXPECT_EQ(controls_.steering.scene, SceneClock::Stands);
}

TEST_F(ControlsTest, MaskRateAndPathStayWithinTheirLimits) {
  act(Act::SlowerMasks, 9);
  EXPECT_EQ(controls_.steering.wish.every, kRarestMasks);
  act(Act::FasterMasks, 9);
  EXPECT_EQ(controls_.steering.wish.every, 1u);
  act(Act::WorsePath);
  EXPECT_EQ(controls_.path.latency_ms, 25);
  act(Act::WorsePath, 99);
  EXPECT_EQ(controls_.path.latency_ms, kWorstPath.latency_ms);
  act(Act::BetterPath, 99);
  EXPECT_EQ(controls_.path, NetworkSettings{});
}

TEST(NetworkSettings, ChangesWhatItNamesAndLeavesTheRest) {
  const LinkModel base{.reorder = 0.1, .seed = 7};
  const LinkModel model = path_of({.latency_ms = 40, .jitter_ms = 10, .loss_percent = 5}, base);
  EXPECT_EQ(model.delay, 40ms);
  EXPECT_EQ(model.jitter, 10ms);
  EXPECT_DOUBLE_EQ(model.loss, 0.05);
  EXPECT_EQ(model.reorder, 0.1);
  EXPECT_EQ(model.seed, 7u);
}

TEST_F(ControlsTest, SwitchesTheSelectedLightAlone) {
  act(Act::NextLight);
  EXPECT_EQ(controls_.light, 1u);
  act(Act::LightOnOff);
  ASSERT_EQ(controls_.steering.lights.lights.size(), 1u);
  EXPECT_EQ(last_change().light, 1u);
  EXPECT_FALSE(last_change().on);
  act(Act::LightOnOff);
  EXPECT_TRUE(last_change().on);
  act(Act::NextLight);
  EXPECT_EQ(controls_.light, 0u);
}

TEST_F(ControlsTest, GrabbedLightKeepsItsPlaceBeforeTheHead) {
  act(Act::GrabLight);
  head_ = {glm::angleAxis(std::numbers::pi / 2, glm::dvec3(0, 1, 0)), {10, 0, 0}};
  carry_light(controls_, stand(), 0);
  // (1, 2, 3) before a head at the origin, turned by 90 degrees to the left about +y and taken along.
  const glm::dvec3 at = last_change().pose->position.v;
  EXPECT_NEAR(at.x, 13, 1e-12);
  EXPECT_NEAR(at.y, 2, 1e-12);
  EXPECT_NEAR(at.z, -1, 1e-12);
  EXPECT_NEAR(glm::length(last_change().pose->direction.v), 1, 1e-12);
  const std::uint32_t revision = controls_.steering.lights.revision;
  carry_light(controls_, stand(), 0);
  EXPECT_EQ(controls_.steering.lights.revision, revision) << "what does not move makes no light set";
  act(Act::GrabLight);
  head_ = {};
  carry_light(controls_, stand(), 0);
  EXPECT_EQ(last_change().pose->position.v, at) << "let go";
}

TEST_F(ControlsTest, WheelBringsAGrabbedLightFurtherAndNearer) {
  act(Act::GrabLight);
  carry_light(controls_, stand(), 1);
  const double far = glm::length(last_change().pose->position.v);
  EXPECT_NEAR(far / glm::length(glm::dvec3(1, 2, 3)), 1.1, 1e-12);
  carry_light(controls_, stand(), -1000);
  EXPECT_GT(glm::length(last_change().pose->position.v), 0);
  EXPECT_LT(glm::length(last_change().pose->position.v), 0.1);
}

TEST_F(ControlsTest, LightWithoutDirectionIsGrabbedWithOne) {
  act(Act::NextLight);
  act(Act::GrabLight);
  carry_light(controls_, stand(), 1);
  EXPECT_NEAR(glm::length(last_change().pose->direction.v), 1, 1e-12);
}

TEST_F(ControlsTest, ResetGivesAllLightsBackToTheScene) {
  act(Act::LightOnOff);
  act(Act::NextLight);
  act(Act::GrabLight);
  carry_light(controls_, stand(), 1);
  act(Act::ResetLights);
  EXPECT_FALSE(controls_.grab);
  for (const LightChange& change : controls_.steering.lights.lights) {
    EXPECT_TRUE(change.on);
    EXPECT_FALSE(change.pose);
  }
  const std::uint32_t revision = controls_.steering.lights.revision;
  act(Act::ResetLights);
  EXPECT_EQ(controls_.steering.lights.revision, revision);
}

TEST_F(ControlsTest, RecordingIsPlayedByKeys) {
  act(Act::HeadSource);
  EXPECT_EQ(controls_.head, HeadSource::Recording);
  act(Act::Forward, 2);
  EXPECT_EQ(player_.position(), 2s);
  act(Act::Back);
  EXPECT_EQ(player_.position(), 1s);
  act(Act::PlayPause);
  EXPECT_FALSE(player_.playing());
  act(Act::Slower);
  EXPECT_EQ(player_.speed(), 0.5);
  act(Act::Faster, 2);
  EXPECT_EQ(player_.speed(), 2);
  act(Act::Loop);
  EXPECT_EQ(player_.at_end(), AtEnd::Loop);
}

TEST_F(ControlsTest, WithoutARecordingTheHeadStaysInHand) {
  farshade::act(Act::HeadSource, controls_, {lights_, head_, nullptr});
  farshade::act(Act::PlayPause, controls_, {lights_, head_, nullptr});
  EXPECT_EQ(controls_.head, HeadSource::Hand);
}

TEST_F(ControlsTest, FieldOfViewStartsFromTheRecordingsOwn) {
  const EyeFov own{-0.7, 0.8, 0.6, -0.5};
  controls_.recorded_fov = PerEye<EyeFov>{own, own};
  EXPECT_EQ(headset_of(controls_, {100, 100}).fov[1], own);
  act(Act::WiderFov);
  EXPECT_NEAR(controls_.fov_rad, 1.1 + 5 * std::numbers::pi / 180, 1e-12);
  EXPECT_NE(headset_of(controls_, {100, 100}).fov[1], own);
  act(Act::NarrowerFov, 99);
  EXPECT_EQ(controls_.fov_rad, kNarrowestView_rad);
  act(Act::WiderFov, 99);
  EXPECT_EQ(controls_.fov_rad, kWidestView_rad);
}

TEST_F(ControlsTest, EyesStayBetweenTogetherAndFarApart) {
  act(Act::CloserEyes, 99);
  EXPECT_EQ(controls_.eye_distance_m, 0);
  act(Act::WiderEyes, 99);
  EXPECT_EQ(controls_.eye_distance_m, kWidestEyes_m);
}

TEST_F(ControlsTest, WhatIsWantedOnceIsTakenOnce) {
  act(Act::Screenshot);
  EXPECT_FALSE(controls_.take(Act::RecordHead));
  EXPECT_TRUE(controls_.take(Act::Screenshot));
  EXPECT_FALSE(controls_.take(Act::Screenshot));
  act(Act::NextLook);
  EXPECT_FALSE(controls_.take(Act::NextLook));
}

TEST_F(ControlsTest, ReportsAreMadeForThoseWhoLookIntoThem) {
  EXPECT_EQ(report_for(controls_), ShadingPass::Report::Off);
  obey({.pressed = {Key::O}, .held = {}}, controls_, stand());
  EXPECT_EQ(controls_.overlay, Overlay::Source);
  EXPECT_EQ(controls_.steering.report, ShadingPass::Report::On);
  obey({.pressed = {Key::Digit0}, .held = {}}, controls_, stand());
  EXPECT_EQ(controls_.steering.report, ShadingPass::Report::Off);
  act(Act::Reference);
  EXPECT_EQ(report_for(controls_), ShadingPass::Report::On);
}

TEST(HeadInputOf, ReadsHeldKeysAndTheMouse) {
  Input input;
  for (const Key key : {Key::W, Key::D, Key::Shift}) input.held.set(static_cast<std::size_t>(key));
  input.drag_px = {3, -4};
  const HeadInput head = head_input(input);
  EXPECT_EQ(head.walk, glm::dvec3(1, 0, -1));
  EXPECT_EQ(head.turn_px, glm::dvec2(3, -4));
  EXPECT_EQ(head.gait, Gait::Run);
  input.held.set(static_cast<std::size_t>(Key::S));
  EXPECT_EQ(head_input(input).walk.z, 0);
}

}  // namespace
}  // namespace farshade
