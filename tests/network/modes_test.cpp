// Complete runs of every mode. Over a perfect network, the pictures equal those of `full`, except for the
// error of the mode. Over a network with loss, the run continues.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "stereo/requests/guard_band.h"
#include "stereo/video/video.h"
#include "tests/network/rehearsal.h"
#include "tests/oracle/oracle.h"
#include "tests/oracle/scene_builder.h"
#include "tests/support/test_place.h"

namespace farshade {
namespace {

bool needs_video(Mode mode) {
  return mode == Mode::Remote || mode == Mode::Delta;
}

using namespace std::chrono_literals;

struct Setup {
  gpu::Device device =
      gpu::open_device({.name_contains = test_gpu(), .validation = gpu::Validation::On}).value();
  Scene scene = load_scene(asset("room.glb")).value();
  HeadRecording head = load_head_recording(asset("walk.csv"), {}).value();
};
const Setup& setup() {
  static const Setup shared;
  return shared;
}

Play play_of(const ModeSettings& mode, std::uint32_t frames) {
  return {.device = setup().device,
          .scene = setup().scene,
          .head = setup().head,
          .size = {160, 128},
          .frames = frames,
          .reference_every = 3,
          .mode = mode};
}

/// The PSNR of the worse eye, for each compared frame.
std::vector<double> psnr_of(const Played& played) {
  std::vector<double> values;
  for (const FrameRecord& record : played.log.records())
    if (record.errors && !record.start_up)
      values.push_back(std::min((*record.errors)[0].psnr_db, (*record.errors)[1].psnr_db));
  return values;
}

/// PSNR over the selected pixels; 99 dB if they are equal.
double psnr_where(const Image<Rgb8>& shown, const Image<Rgb8>& reference, const auto& counts) {
  double squares = 0, values = 0;
  for (std::size_t i = 0; i < shown.pixels.size(); ++i)
    if (counts(i)) {
      const glm::dvec3 by = glm::dvec3(shown.pixels[i]) - glm::dvec3(reference.pixels[i]);
      squares += glm::dot(by, by);
      values += 3;
    }
  return std::min(99.0, 10 * std::log10(255.0 * 255.0 * values / std::max(squares, 1e-9)));
}

struct Case {
  ModeSettings mode;
  double least_dB;  ///< the least PSNR of any frame
};

std::string name(const testing::TestParamInfo<Case>& info) {
  std::string text(name_of(info.param.mode.mode));
  std::erase(text, '-');
  return text + std::to_string(info.index);
}

class EveryMode : public testing::TestWithParam<Case> {};

/// The request is for the shown views and the frame waits for it: no age, no pose difference.
TEST_P(EveryMode, ShowsThePictureOfFullIfNothingIsLate) {
  const auto& [mode, least_dB] = GetParam();
  if (needs_video(mode.mode) && !has_video()) GTEST_SKIP() << video_version();
  Play play = play_of(mode, 10);
  play.request = {.predictor = PredictorKind::Hold, .guard_band = GuardBandUse::Off};
  play.mask_wait = 1s;
  const Played played = farshade::play(play, {.name = "none", .model = {}});
  const std::vector<double> psnr = psnr_of(played);
  ASSERT_EQ(psnr.size(), 4u) << "each measured frame had an answer";
  EXPECT_GE(*std::ranges::min_element(psnr), least_dB);
  EXPECT_EQ(setup().device.validation_log->messages(), std::vector<std::string>{});
}

// Exact masks give 50 dB. Positions come from the rasteriser, which at an edge sees another surface than a
// ray; PositionsMode tests the effect. Video and shadow maps have limits of their own.
INSTANTIATE_TEST_SUITE_P(Modes, EveryMode,
                         testing::Values(Case{{.mode = Mode::Hybrid}, 50}, Case{{.mode = Mode::Full}, 50},
                                         Case{{.mode = Mode::ClientPositions, .position_bits = 24}, 36},
                                         Case{{.mode = Mode::ServerGBuffer}, 50},
                                         Case{{.mode = Mode::Remote, .bits_per_second = 50'000'000}, 31},
                                         Case{{.mode = Mode::Delta, .bits_per_second = 50'000'000}, 31},
                                         Case{{.mode = Mode::Local, .shadow_maps = {.side_px = 2048}}, 22}),
                         name);

/// Box over plane with lights that go from a quarter to all of their intensity within a second. Nothing
/// moves.
Scene brightening() {
  Scene scene = load_scene(asset("box_over_plane.gltf")).value();
  LightTrack track;
  track.keys_s = {0, 1};
  track.values = {glm::vec4(0.25f), glm::vec4(1)};
  for (LightSource& light : scene.lights) light.animation = {light.intensity, 1, 1, {track}};
  scene.animation_length_s = 1;
  return scene;
}

double brightness(const Image<Rgb8>& picture) {
  double sum = 0;
  for (const Rgb8& pixel : picture.pixels) sum += pixel.y;
  return sum;
}

class EveryLateMode : public testing::TestWithParam<ModeSettings> {};

/// What the server sends is 80 ms old when it is shown. The head stands still.
TEST_P(EveryLateMode, IsAsBrightAsTheLightsAreNow) {
  const ModeSettings mode = GetParam();
  if (needs_video(mode.mode) && !has_video()) GTEST_SKIP() << video_version();
  const Scene scene = brightening();
  HeadRecording head = setup().head;
  for (auto& sample : head.samples) sample.recorded_from_head = head.samples[0].recorded_from_head;
  Play play{.device = setup().device, .scene = scene, .head = head, .size = {96, 96}, .frames = 36};
  play.reference_every = 5;
  play.mode = mode;
  std::vector<double> wrong;
  play.watch = [&](const FrameView&, const FrameRecord& record, const MeasuredFrame* frame) {
    if (frame != nullptr && !record.start_up)
      wrong.push_back(std::abs(1 - brightness(frame->shown[0]) / brightness(frame->reference[0])));
  };
  static_cast<void>(farshade::play(play, network_from("delay=40ms").value()));
  ASSERT_GT(wrong.size(), 3u);
  EXPECT_LT(*std::ranges::max_element(wrong), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Modes, EveryLateMode,
                         testing::Values(ModeSettings{.mode = Mode::Hybrid}, ModeSettings{.mode = Mode::Full},
                                         ModeSettings{.mode = Mode::ClientPositions},
                                         ModeSettings{.mode = Mode::ServerGBuffer},
                                         ModeSettings{.mode = Mode::Remote, .bits_per_second = 50'000'000},
                                         ModeSettings{.mode = Mode::Delta, .bits_per_second = 50'000'000},
                                         ModeSettings{.mode = Mode::Local}),
                         [](const testing::TestParamInfo<ModeSettings>& made) {
                           std::string text(name_of(made.param.mode));
                           std::erase(text, '-');
                           return text;
                         });

std::string mode_name(const testing::TestParamInfo<Mode>& info) {
  std::string text(name_of(info.param));
  std::erase(text, '-');
  return text;
}

class EveryServedMode : public testing::TestWithParam<Mode> {};

TEST_P(EveryServedMode, ContinuesWhenDatagramsAreLost) {
  const Mode mode = GetParam();
  if (needs_video(mode) && !has_video()) GTEST_SKIP() << video_version();
  std::optional<FrameId> newest;
  std::size_t renewed = 0;
  Play play = play_of({.mode = mode}, 60);
  play.reference_every = 0;
  play.watch = [&](const FrameView& view, const FrameRecord&, const MeasuredFrame*) {
    if (view.newest == nullptr) return;
    EXPECT_FALSE(newest && is_newer(*newest, view.newest->request.frame)) << "none goes back";
    renewed += newest != view.newest->request.frame ? 1 : 0;
    newest = view.newest->request.frame;
  };
  const Played played = farshade::play(play, network_from("loss=3%,delay=10ms").value());
  EXPECT_EQ(played.frames.size(), 60u);
  EXPECT_GT(renewed, 5u);
  ASSERT_FALSE(played.log.records().empty());
  EXPECT_LT(played.log.start_up_frames(), 20u);
}

INSTANTIATE_TEST_SUITE_P(Modes, EveryServedMode,
                         testing::Values(Mode::Hybrid, Mode::ClientPositions, Mode::ServerGBuffer,
                                         Mode::Remote, Mode::Delta),
                         mode_name);

/// Turns on the spot, 40 degrees/s to the left, so that there is almost no parallax.
HeadRecording turning() {
  HeadRecording head = setup().head;
  head.samples.clear();
  for (int i = 0; i < 100; ++i)
    head.samples.push_back(
        {Time(i * 10ms), {glm::angleAxis(glm::radians(0.4 * i), glm::dvec3(0, 1, 0)), {}}});
  return head;
}

class EveryPictureMode : public testing::TestWithParam<Case> {};

/// A picture drawn for an earlier pose shows the geometry at its current position.
TEST_P(EveryPictureMode, IsTurnedToTheShownPose) {
  const ModeSettings mode = GetParam().mode;
  const double least_dB = GetParam().least_dB;
  if (needs_video(mode.mode) && !has_video()) GTEST_SKIP() << video_version();
  const Scene scene = load_scene(asset("box_over_plane.gltf")).value();
  const HeadRecording head = turning();
  Play play{.device = setup().device, .scene = scene, .head = head, .size = {160, 128}};
  play.frames = 30;
  play.reference_every = 3;
  play.mode = mode;
  play.request.predictor = PredictorKind::Hold;
  std::size_t measured = 0;
  play.watch = [&](const FrameView&, const FrameRecord& record, const MeasuredFrame* frame) {
    if (frame == nullptr || record.start_up) return;
    ++measured;
    const auto reached = [](std::size_t pixel) { return pixel % 160 >= 20 && pixel / 160 < 110; };
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      EXPECT_GE(psnr_where(frame->shown[eye], frame->reference[eye], reached), least_dB) << "eye " << eye;
  };
  static_cast<void>(farshade::play(play, network_from("delay=40ms").value()));
  EXPECT_GT(measured, 5u);
}

// Without turning the pictures, these modes have 20, 20 and 28 dB. After turning them, only resampling at
// edges causes errors.
INSTANTIATE_TEST_SUITE_P(Modes, EveryPictureMode,
                         testing::Values(Case{{.mode = Mode::ServerGBuffer}, 27},
                                         Case{{.mode = Mode::Remote, .bits_per_second = 50'000'000}, 27},
                                         Case{{.mode = Mode::Delta, .bits_per_second = 50'000'000}, 34}),
                         name);

/// A head that turns sees areas outside the server's picture. They are black and counted.
TEST(RemoteMode, CountsWhatItsPictureDoesNotReach) {
  if (!has_video()) GTEST_SKIP() << video_version();
  Play play = play_of({.mode = Mode::Remote}, 30);
  play.request = {.predictor = PredictorKind::Hold, .guard_band = GuardBandUse::Off};
  double most = 0;
  play.watch = [&](const FrameView& view, const FrameRecord& record, const MeasuredFrame*) {
    EXPECT_EQ(view.as, ShownAs::Picture);
    if (!view.start_up) most = std::max(most, record.black[0]);
  };
  static_cast<void>(farshade::play(play, network_from("delay=40ms").value()));
  EXPECT_GT(most, 0.001);
  EXPECT_LT(most, 0.5);
}

/// What the shown frames of a run with pictures have in common.
struct PictureRun {
  double black = 0;                  ///< sum of the shares of both eyes that the pictures do not reach
  std::size_t renewed = 0;           ///< frames with a newer picture than the frame before
  std::size_t key_frames_asked = 0;  ///< requests for a picture that depends on no other
  std::size_t sizes = 0;             ///< changes of the requested size
  std::vector<double> psnr_dB;

  friend bool operator==(const PictureRun&, const PictureRun&) = default;
};

PictureRun run_of(Play play, const char* network) {
  PictureRun run;
  std::optional<FrameId> newest;
  std::optional<Extent> size;
  play.watch = [&](const FrameView& view, const FrameRecord& record, const MeasuredFrame*) {
    if (view.request != nullptr) {
      run.key_frames_asked += view.request->answer.coding == Coding::Alone ? 1 : 0;
      const Extent requested = view.request->views[0].size, most = largest_traced(view.shown.views[0].size);
      EXPECT_LE(requested.width, most.width);
      EXPECT_LE(requested.height, most.height);
      run.sizes += size && size != requested ? 1 : 0;
      size = requested;
    }
    if (view.start_up || view.newest == nullptr) return;
    run.black += record.black[0] + record.black[1];
    run.renewed += newest != view.newest->request.frame ? 1 : 0;
    newest = view.newest->request.frame;
  };
  run.psnr_dB = psnr_of(farshade::play(play, network_from(network).value()));
  return run;
}

class EveryVideoMode : public testing::TestWithParam<Mode> {
 protected:
  void SetUp() override {
    if (!has_video()) GTEST_SKIP() << video_version();
  }
};

TEST_P(EveryVideoMode, AGuardBandLeavesLessUncovered) {
  Play play = play_of({.mode = GetParam()}, 60);
  play.reference_every = 0;
  const PictureRun with = run_of(play, "delay=25ms");
  play.request.guard_band = GuardBandUse::Off;
  const PictureRun without = run_of(play, "delay=25ms");
  EXPECT_GT(without.black, 0.01);
  EXPECT_LT(with.black, 0.3 * without.black);
  EXPECT_EQ(without.sizes, 0u);
  EXPECT_GT(with.sizes, 0u);
  EXPECT_LE(with.sizes, 4u) << "each costs a key frame";
}

/// Without the intra refresh, each lost datagram stopped the pictures until a key frame had come.
TEST_P(EveryVideoMode, FreshPicturesGoOnWithoutKeyFramesAfterLosses) {
  Play play = play_of({.mode = GetParam()}, 72);
  play.reference_every = 8;
  const PictureRun lossy = run_of(play, "delay=25ms,loss=2%");
  const PictureRun whole = run_of(play, "delay=25ms");
  EXPECT_EQ(whole.key_frames_asked, 1u) << "the first picture";
  EXPECT_LE(lossy.key_frames_asked, 3u);
  EXPECT_GT(lossy.renewed, 72u / 2);
  ASSERT_EQ(lossy.psnr_dB.size(), whole.psnr_dB.size());
  for (std::size_t i = 0; i < whole.psnr_dB.size(); ++i)
    EXPECT_GT(lossy.psnr_dB[i], whole.psnr_dB[i] - 6) << "measured frame " << i;
  EXPECT_EQ(run_of(play, "delay=25ms,loss=2%"), lossy) << "runs in virtual time are repeatable";
}

INSTANTIATE_TEST_SUITE_P(Modes, EveryVideoMode, testing::Values(Mode::Remote, Mode::Delta), mode_name);

class DrawnAhead : public testing::TestWithParam<Mode> {};

/// No display time of a real clock waits for a compiler.
TEST_P(DrawnAhead, CompilesNothingLater) {
  const ModeSettings mode{.mode = GetParam()};
  if (needs_video(mode.mode) && !has_video()) GTEST_SKIP() << video_version();
  Play play = play_of(mode, 8);
  play.reference_every = 0;  // comparisons of a real clock come after the run
  play.start = Play::Start::DrawnAhead;
  const Played played = farshade::play(play, {.name = "delay=25ms", .model = {.delay = 25ms}});
  EXPECT_TRUE(std::ranges::any_of(played.log.records(), [](auto& record) { return !record.start_up; }));
  ASSERT_EQ(played.frames.size(), 8u);
  for (const PlayedFrame& frame : played.frames) EXPECT_EQ(frame.pipelines, played.frames.front().pipelines);
  play.start = Play::Start::Cold;
  play.frames = 1;
  const Played cold = farshade::play(play, {.name = "none", .model = {}});
  EXPECT_GE(played.frames.front().pipelines, cold.frames.front().pipelines);
}

INSTANTIATE_TEST_SUITE_P(Modes, DrawnAhead,
                         testing::Values(Mode::Remote, Mode::ServerGBuffer, Mode::Delta, Mode::Full),
                         mode_name);

/// The reference's rays and the client's rasteriser disagree about pixels through which the edge of an object
/// or a shadow runs: the oracle's band. Elsewhere masks of positions are exact.
TEST(PositionsMode, IsExactExceptForPixelsWithAnEdge) {
  Play play = play_of({.mode = Mode::ClientPositions, .position_bits = 24}, 7);
  play.request = {.predictor = PredictorKind::Hold, .guard_band = GuardBandUse::Off};
  play.mask_wait = 1s;
  std::size_t measured = 0;
  play.watch = [&](const FrameView& view, const FrameRecord& record, const MeasuredFrame* frame) {
    if (frame == nullptr || record.start_up) return;
    ++measured;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const oracle::Masks truth = oracle::trace(setup().scene, view.state, view.shown.views[eye]);
      const auto is_clear = [&](std::size_t pixel) {
        const auto first = truth.in_band.begin() + static_cast<std::ptrdiff_t>(pixel * truth.lights);
        return std::none_of(first, first + truth.lights, [](std::uint8_t in_band) { return in_band != 0; });
      };
      const double psnr_dB = psnr_where(frame->shown[eye], frame->reference[eye], is_clear);
      std::size_t clear = 0;
      for (std::size_t pixel = 0; pixel < truth.covered.size(); ++pixel) clear += is_clear(pixel) ? 1 : 0;
      const double whole_dB =
          psnr_where(frame->shown[eye], frame->reference[eye], [](std::size_t) { return true; });
      std::cout << "eye " << eye << ": " << whole_dB << " dB, without edges " << psnr_dB << " dB\n";
      EXPECT_GE(psnr_dB, 50) << "eye " << eye;
      EXPECT_GT(clear, truth.covered.size() * 4 / 5) << "eye " << eye;
    }
  };
  static_cast<void>(farshade::play(play, {.name = "none", .model = {}}));
  EXPECT_EQ(measured, 3u);
}

/// A box leaves the bounds that the scene has at time 0 by many times its size. Another one stays, and its
/// shadow, which shows whether both sides mean the same positions.
TEST(PositionsMode, SeesWhatLeavesTheBoundsOfTheBeginning) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 1}, {1, 0, 0}));
  builder.move(builder.add(box({0, 0.5, 0}, {0.4, 0.4, 0.4})), {3, 1, 0});
  builder.add(box({-0.3, 0.4, 0.2}, {0.3, 0.3, 0.3}));
  builder.point_light({2, 4, 4});
  Scene scene = builder.build();
  const View camera = look({2, 1.5, 4}, {2, 0.8, 0}, 2);
  scene.camera = camera.stage_from_eye;
  Play play{.device = setup().device, .scene = scene, .head = setup().head, .size = {96, 96}, .frames = 66};
  play.reference_every = 5;
  play.mode = {.mode = Mode::ClientPositions, .position_bits = 24};
  play.request = {.predictor = PredictorKind::Hold, .guard_band = GuardBandUse::Off};
  play.mask_wait = 1s;
  const std::vector<double> psnr = psnr_of(farshade::play(play, {.name = "none", .model = {}}));
  ASSERT_GT(psnr.size(), 10u);
  EXPECT_GE(*std::ranges::min_element(psnr), 50) << "60 dB, and 38 with the grid of the beginning";
}

/// Errors of masks are reported for scenes with lights only.
TEST(LocalMode, ReportsTheErrorOfItsMaps) {
  const Played played = farshade::play(play_of({.mode = Mode::Local}, 4), {.name = "none", .model = {}});
  for (const FrameRecord& record : played.log.records())
    if (record.errors) {
      EXPECT_GT((*record.errors)[0].mask_error, 0.0);
      EXPECT_LT((*record.errors)[0].mask_error, 0.08);
    }
}

}  // namespace
}  // namespace farshade
