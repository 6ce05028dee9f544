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
  ControlContext context() { return {lights_, head_, &player_}; }
  void execute(Command command, int times = 1) {
    for (int i = 0; i < times; ++i) farshade::execute(command, controls_, context());
  }
  const LightChange& last_change() { return controls_.settings.lights.lights.back(); }

  LightSet lights_ = two_lights();
  Rigid<Stage, Head> head_;
  Player player_{10s};
  Controls controls_;
};

TEST(KeyBindings, NameEachKeyOnceAndReachEveryCommand) {
  std::set<Key> keys;
  std::set<Command> commands;
  std::set<std::string> names;
  for (const KeyBinding& binding : key_bindings()) {
    EXPECT_TRUE(keys.insert(binding.key).second) << name_of(binding.key);
    EXPECT_TRUE(names.insert(name_of(binding.key)).second) << name_of(binding.key);
    commands.insert(binding.command);
    EXPECT_STRNE(binding.description, "");
  }
  EXPECT_EQ(commands.size(), kCommands);
  for (const Key walks : {Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E}) EXPECT_FALSE(keys.contains(walks));
}

TEST(KeyNames, AreTheLabelsOfTheKeyboard) {
  EXPECT_EQ(name_of(Key::A), "A");
  EXPECT_EQ(name_of(Key::Z), "Z");
  EXPECT_EQ(name_of(Key::Digit0), "0");
  EXPECT_EQ(name_of(Key::F12), "F12");
  EXPECT_EQ(name_of(Key::Space), "Space");
  EXPECT_EQ(name_of(Key::Control), "Ctrl");
}

TEST_F(ControlsTest, DisplayModesAndOverlaysCycle) {
  std::set<DisplayMode> modes;
  for (std::size_t i = 0; i < kDisplayModes.size(); ++i, execute(Command::NextDisplayMode))
    modes.insert(controls_.display);
  EXPECT_EQ(modes.size(), kDisplayModes.size());
  EXPECT_EQ(controls_.display, DisplayMode::SideBySide);
  std::set<Overlay> overlays;
  for (std::size_t i = 0; i < kOverlays.size(); ++i, execute(Command::NextOverlay))
    overlays.insert(controls_.overlay);
  EXPECT_EQ(overlays.size(), kOverlays.size());
  execute(Command::NextOverlay, 3);
  execute(Command::NoOverlay);
  EXPECT_EQ(controls_.overlay, Overlay::None);
}

TEST(KeyHelp, HasEveryKeyOnce) {
  std::set<std::string> keys;
  for (const KeyHelp& help : key_help({})) EXPECT_TRUE(keys.insert(help.keys).second) << help.keys;
  EXPECT_EQ(keys.size(), key_bindings().size() + 3);
  for (const KeyBinding& binding : key_bindings()) EXPECT_TRUE(keys.contains(name_of(binding.key)));
}

TEST_F(ControlsTest, CommandsThatTheRunLacksDoNothing) {
  controls_.absent.set(static_cast<std::size_t>(Command::Reference));
  controls_.absent.set(static_cast<std::size_t>(Command::HeadSource));
  controls_.absent.set(static_cast<std::size_t>(Command::Screenshot));
  for (const Command command : {Command::Reference, Command::HeadSource, Command::Screenshot})
    execute(command);
  EXPECT_FALSE(controls_.reference);
  EXPECT_EQ(controls_.head, HeadSource::Simulated);
  EXPECT_TRUE(controls_.pending.none());
  for (std::size_t i = 0; i < 2 * kOverlays.size(); ++i, execute(Command::NextOverlay)) {
    EXPECT_FALSE(needs_reference(controls_)) << name_of(controls_.overlay);
    execute(Command::NextDisplayMode);
  }
  const std::vector<KeyHelp> keys = key_help(controls_);
  EXPECT_EQ(keys.size(), key_bindings().size() - 3) << "three commands less, and no keys for the head";
}

TEST_F(ControlsTest, ARunThatMeasuresReportsEveryFrame) {
  EXPECT_EQ(report_for(controls_), PixelReport::Off);
  controls_.least_report = PixelReport::On;
  EXPECT_EQ(report_for(controls_), PixelReport::On);
}

TEST_F(ControlsTest, ThePictureShinesThroughInSteps) {
  std::vector<double> shares;
  controls_.picture_share = 0.1;
  for (int i = 0; i < 5; ++i) {
    execute(Command::PictureShare);
    shares.push_back(controls_.picture_share);
  }
  EXPECT_EQ(shares, (std::vector<double>{0.25, 0.5, 0.75, 0, 0.25}));
}

TEST_F(ControlsTest, ReprojectionGuardBandAndPredictorsChangeTheFrameSettings) {
  execute(Command::Reprojection);
  EXPECT_EQ(controls_.settings.reprojection.lookup, Lookup::Direct);
  execute(Command::Reprojection);
  EXPECT_EQ(controls_.settings.reprojection.lookup, Lookup::Reproject);
  execute(Command::AskWhole);
  EXPECT_EQ(controls_.settings.request.asks, Asks::Whole);
  execute(Command::GuardBand);
  EXPECT_EQ(controls_.settings.request.guard_band, GuardBandUse::Off);
  std::set<PredictorKind> predictors;
  for (std::size_t i = 0; i < std::size(kPredictorKinds); ++i, execute(Command::NextPredictor))
    predictors.insert(controls_.settings.request.predictor);
  EXPECT_EQ(predictors.size(), std::size(kPredictorKinds));
  EXPECT_EQ(controls_.settings.request.predictor, kDefaultPredictor);
  execute(Command::Animation);
  EXPECT_EQ(controls_.settings.scene, SceneClock::Paused);
}

TEST_F(ControlsTest, TheInspectorOpensItsTabAndTheFrameReports) {
  controls_.panel = false;
  execute(Command::Inspector);
  EXPECT_EQ(controls_.wanted_tab, Tab::Pixel);
  EXPECT_TRUE(controls_.panel) << "the facts are in the panel";
  EXPECT_TRUE(inspects_pixel(controls_));
  EXPECT_EQ(report_for(controls_), PixelReport::On);
  EXPECT_FALSE(replaces_pictures(controls_));
  execute(Command::Panel);
  EXPECT_EQ(report_for(controls_), PixelReport::Off) << "nobody sees it";
  execute(Command::Panel);
  execute(Command::Inspector);
  EXPECT_EQ(controls_.wanted_tab, Tab::View);
  EXPECT_EQ(report_for(controls_), PixelReport::Off);
}

TEST_F(ControlsTest, ModesCycleAmongThoseOffered) {
  execute(Command::NextMode);
  EXPECT_EQ(controls_.mode, Mode::Hybrid) << "nothing is offered";
  controls_.modes = {Mode::Hybrid, Mode::Local, Mode::Full};
  execute(Command::NextMode);
  EXPECT_EQ(controls_.mode, Mode::Local);
  execute(Command::NextMode, 2);
  EXPECT_EQ(controls_.mode, Mode::Hybrid);
  std::erase(controls_.modes, Mode::Hybrid);
  execute(Command::NextMode);
  EXPECT_EQ(controls_.mode, Mode::Local) << "after one that is offered no more";
}

TEST_F(ControlsTest, AFrameIsHeldUntilTheTimeRunsAndTheNextOneIsAskedForOnce) {
  execute(Command::NextFrame);
  EXPECT_TRUE(controls_.held);
  EXPECT_FALSE(controls_.take(Command::NextFrame)) << "the first press holds the shown frame";
  execute(Command::NextFrame, 2);
  EXPECT_TRUE(controls_.take(Command::NextFrame));
  EXPECT_FALSE(controls_.take(Command::NextFrame));
  execute(Command::NextFrame);
  execute(Command::HoldFrame);
  EXPECT_FALSE(controls_.held);
  execute(Command::HoldFrame);
  EXPECT_TRUE(controls_.held);
  EXPECT_FALSE(controls_.take(Command::NextFrame)) << "of an earlier hold";
}

TEST_F(ControlsTest, AHeldFrameReports) {
  EXPECT_EQ(report_for(controls_), PixelReport::Off);
  execute(Command::HoldFrame);
  EXPECT_EQ(report_for(controls_), PixelReport::On);
}

TEST_F(ControlsTest, MaskRateAndPathStayWithinTheirLimits) {
  execute(Command::SlowerMasks, 9);
  EXPECT_EQ(controls_.settings.request.every, kRarestMasks);
  execute(Command::FasterMasks, 9);
  EXPECT_EQ(controls_.settings.request.every, 0u) << "as often as needed";
  execute(Command::WorsePath);
  EXPECT_EQ(controls_.path.latency_ms, 25);
  execute(Command::WorsePath, 99);
  EXPECT_EQ(controls_.path.latency_ms, kWorstPath.latency_ms);
  execute(Command::BetterPath, 99);
  EXPECT_EQ(controls_.path, NetworkSettings{});
}

TEST(NetworkSettings, ChangeLatencyJitterAndLossOnly) {
  const LinkModel base{.reorder = 0.1, .seed = 7};
  const LinkModel model = path_of({.latency_ms = 40, .jitter_ms = 10, .loss_percent = 5}, base);
  EXPECT_EQ(model.delay, 40ms);
  EXPECT_EQ(model.jitter, 10ms);
  EXPECT_DOUBLE_EQ(model.loss, 0.05);
  EXPECT_EQ(model.reorder, 0.1);
  EXPECT_EQ(model.seed, 7u);
}

TEST_F(ControlsTest, SwitchesOnlyTheSelectedLight) {
  execute(Command::NextLight);
  EXPECT_EQ(controls_.light, 1u);
  execute(Command::LightOnOff);
  ASSERT_EQ(controls_.settings.lights.lights.size(), 1u);
  EXPECT_EQ(last_change().light, 1u);
  EXPECT_FALSE(last_change().on);
  execute(Command::LightOnOff);
  EXPECT_TRUE(last_change().on);
  execute(Command::NextLight);
  EXPECT_EQ(controls_.light, 0u);
}

TEST_F(ControlsTest, GrabbedLightMovesWithTheHead) {
  execute(Command::GrabLight);
  head_ = {glm::angleAxis(std::numbers::pi / 2, glm::dvec3(0, 1, 0)), {10, 0, 0}};
  carry_light(controls_, context(), 0);
  // The light at (1, 2, 3) relative to the head, which turns left by 90 degrees about +y and moves.
  const glm::dvec3 at = last_change().pose->position.v;
  EXPECT_NEAR(at.x, 13, 1e-12);
  EXPECT_NEAR(at.y, 2, 1e-12);
  EXPECT_NEAR(at.z, -1, 1e-12);
  EXPECT_NEAR(glm::length(last_change().pose->direction.v), 1, 1e-12);
  const LightSetRevision revision = controls_.settings.lights.revision;
  carry_light(controls_, context(), 0);
  EXPECT_EQ(controls_.settings.lights.revision, revision) << "without movement there is no new light set";
  execute(Command::GrabLight);
  head_ = {};
  carry_light(controls_, context(), 0);
  EXPECT_EQ(last_change().pose->position.v, at) << "the light was released";
}

TEST_F(ControlsTest, WheelMovesAGrabbedLightFartherAndNearer) {
  execute(Command::GrabLight);
  carry_light(controls_, context(), 1);
  const double far = glm::length(last_change().pose->position.v);
  EXPECT_NEAR(far / glm::length(glm::dvec3(1, 2, 3)), 1.1, 1e-12);
  carry_light(controls_, context(), -1000);
  EXPECT_GT(glm::length(last_change().pose->position.v), 0);
  EXPECT_LT(glm::length(last_change().pose->position.v), 0.1);
}

TEST_F(ControlsTest, GrabbedLightWithoutDirectionGetsOne) {
  execute(Command::NextLight);
  execute(Command::GrabLight);
  carry_light(controls_, context(), 1);
  EXPECT_NEAR(glm::length(last_change().pose->direction.v), 1, 1e-12);
}

TEST_F(ControlsTest, ResetRestoresAllLights) {
  execute(Command::LightOnOff);
  execute(Command::NextLight);
  execute(Command::GrabLight);
  carry_light(controls_, context(), 1);
  execute(Command::ResetLights);
  EXPECT_FALSE(controls_.grab);
  for (const LightChange& change : controls_.settings.lights.lights) {
    EXPECT_TRUE(change.on);
    EXPECT_FALSE(change.pose);
  }
  const LightSetRevision revision = controls_.settings.lights.revision;
  execute(Command::ResetLights);
  EXPECT_EQ(controls_.settings.lights.revision, revision);
}

TEST_F(ControlsTest, KeysControlTheRecording) {
  execute(Command::HeadSource);
  EXPECT_EQ(controls_.head, HeadSource::Recording);
  execute(Command::Forward, 2);
  EXPECT_EQ(player_.position(), 2s);
  execute(Command::Back);
  EXPECT_EQ(player_.position(), 1s);
  execute(Command::PlayPause);
  EXPECT_FALSE(player_.playing());
  execute(Command::Slower);
  EXPECT_EQ(player_.speed(), 0.5);
  execute(Command::Faster, 2);
  EXPECT_EQ(player_.speed(), 2);
  execute(Command::Loop);
  EXPECT_EQ(player_.at_end(), AtEnd::Loop);
}

TEST_F(ControlsTest, WithoutARecordingTheHeadStaysSimulated) {
  farshade::execute(Command::HeadSource, controls_, {lights_, head_, nullptr});
  farshade::execute(Command::PlayPause, controls_, {lights_, head_, nullptr});
  EXPECT_EQ(controls_.head, HeadSource::Simulated);
}

TEST_F(ControlsTest, FieldOfViewStartsFromTheRecording) {
  const EyeFov own{-0.7, 0.8, 0.6, -0.5};
  controls_.recorded_fov = PerEye<EyeFov>{own, own};
  EXPECT_EQ(headset_of(controls_, {100, 100}).fov[1], own);
  execute(Command::WiderFov);
  EXPECT_NEAR(controls_.fov_rad, 1.1 + 5 * std::numbers::pi / 180, 1e-12);
  EXPECT_NE(headset_of(controls_, {100, 100}).fov[1], own);
  execute(Command::NarrowerFov, 99);
  EXPECT_EQ(controls_.fov_rad, kNarrowestView_rad);
  execute(Command::WiderFov, 99);
  EXPECT_EQ(controls_.fov_rad, kWidestView_rad);
}

TEST_F(ControlsTest, EyeDistanceStaysWithinItsLimits) {
  execute(Command::CloserEyes, 99);
  EXPECT_EQ(controls_.eye_distance_m, 0);
  execute(Command::WiderEyes, 99);
  EXPECT_EQ(controls_.eye_distance_m, kWidestEyes_m);
}

TEST_F(ControlsTest, PendingCommandIsExecutedOnce) {
  execute(Command::Screenshot);
  EXPECT_FALSE(controls_.take(Command::RecordHead));
  EXPECT_TRUE(controls_.take(Command::Screenshot));
  EXPECT_FALSE(controls_.take(Command::Screenshot));
  execute(Command::NextDisplayMode);
  EXPECT_FALSE(controls_.take(Command::NextDisplayMode));
}

TEST_F(ControlsTest, ReportsAreOnIfOverlaysOrMeasuringNeedThem) {
  EXPECT_EQ(report_for(controls_), PixelReport::Off);
  apply_input({.pressed = {Key::O}, .held = {}}, controls_, context());
  EXPECT_EQ(controls_.overlay, Overlay::Source);
  EXPECT_EQ(controls_.settings.report, PixelReport::On);
  apply_input({.pressed = {Key::Digit0}, .held = {}}, controls_, context());
  EXPECT_EQ(controls_.settings.report, PixelReport::Off);
  execute(Command::Reference);
  EXPECT_EQ(report_for(controls_), PixelReport::On);
}

TEST(HeadInputOf, ReadsHeldKeysAndTheMouse) {
  Input input;
  for (const Key key : {Key::W, Key::D, Key::Shift}) input.held.set(static_cast<std::size_t>(key));
  input.drag_px = {3, -4};
  const HeadInput head = head_input(input);
  EXPECT_EQ(head.walk, glm::dvec3(1, 0, -1));
  EXPECT_EQ(head.turn_px, glm::dvec2(3, -4));
  EXPECT_EQ(head.speed, MoveSpeed::Run);
  input.held.set(static_cast<std::size_t>(Key::S));
  EXPECT_EQ(head_input(input).walk.z, 0);
}

}  // namespace
}  // namespace farshade
