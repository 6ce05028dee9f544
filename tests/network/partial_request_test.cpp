// Requests for what is unknown, over networks in virtual time: the same masks as from requests for whole
// views, for fewer rays; and losses that are asked for again.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "tests/network/rehearsal.h"
#include "tests/support/test_place.h"

namespace farshade {
namespace {

/// The bundled room at its first instant: nothing moves.
Scene still_room() {
  Scene scene = load_scene(asset("room.glb")).value();
  scene.animation_length_s = 0;
  for (Node& node : scene.nodes) node.moving = false;
  return scene;
}

/// Lenses whose round edges touch the four sides of the pictures. They hide 22 % of the pixels.
PerEye<HiddenArea> round_lenses(const PerEye<EyeFov>& fov) {
  constexpr int kCorners = 48;
  PerEye<HiddenArea> areas;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const auto [left, right, up, down] = tangents_of(fov[eye]);
    const glm::dvec2 middle{(left + right) / 2, (up + down) / 2}, half{(right - left) / 2, (up - down) / 2};
    const auto at = [&](int corner, double out) {
      const double angle = 2 * std::numbers::pi * corner / kCorners;
      return glm::vec2(middle + half * glm::dvec2{std::cos(angle), std::sin(angle)} * out);
    };
    for (int i = 0; i < kCorners; ++i)
      areas[eye].corners.insert(areas[eye].corners.end(),
                                {at(i, 1), at(i, 2), at(i + 1, 1), at(i + 1, 1), at(i, 2), at(i + 1, 2)});
  }
  return areas;
}

struct Measured {
  double mask_error_percent = 0, psnr_db = 0;  ///< means of the compared frames, worse eye
  double worst_unknown_percent = 0;            ///< of the second half of the run
  std::uint64_t rays = 0;                      ///< of all answers
  double requested_percent = 0;                ///< median of the requests
};

struct Setup {
  gpu::Device device = gpu::open_device({.name_contains = test_gpu()}).value();
  Scene scene = still_room();
  HeadRecording head = load_head_recording(asset("walk.csv"), {}).value();
};

/// Scene, device and head for all tests of this program.
const Setup& setup() {
  static const Setup shared;
  return shared;
}

Measured measured(const char* network, Asks asks, const PerEye<HiddenArea>* hidden = nullptr) {
  Play play{.device = setup().device,
            .scene = setup().scene,
            .head = setup().head,
            .size = {512, 512},
            .frames = 64,
            .reference_every = 4};
  play.request.asks = asks;
  play.hidden = hidden;
  const Played played = farshade::play(play, network_from(network).value());
  EXPECT_EQ(played.most_submissions, 1u) << "a request and its picture are one submission";
  const auto mean = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  };
  Measured result{.mask_error_percent = 100 * mean(played.worse_eye(&EyeErrors::mask_error)),
                  .psnr_db = mean(played.worse_eye(&EyeErrors::psnr_db))};
  const std::vector<double> unknown = played.worse_eye(&EyeErrors::unknown);
  for (std::size_t i = unknown.size() / 2; i < unknown.size(); ++i)
    result.worst_unknown_percent = std::max(result.worst_unknown_percent, 100 * unknown[i]);
  for (const FrameReport& report : played.reports) result.rays += report.primary_rays + report.shadow_rays;
  std::vector<double> shares;
  for (const FrameRecord& record : played.log.records())
    if (record.requested) shares.push_back(100 * *record.requested);
  result.requested_percent = quantile(shares, 0.5);
  std::printf("%s: mask error %.4f %%, %.3f dB, unknown %.3f %%, %llu rays, asked %.2f %%\n", network,
              result.mask_error_percent, result.psnr_db, result.worst_unknown_percent,
              static_cast<unsigned long long>(result.rays), result.requested_percent);
  return result;
}

/// Requests for what is unknown, without losses: three tests compare with this run.
const Measured& unknown_without_loss() {
  static const Measured run = measured("delay=25ms", Asks::Unknown);
  return run;
}

TEST(PartialRequest, ForWhatIsUnknownGivesTheSameMasksForFewerRays) {
  const Measured whole = measured("delay=25ms", Asks::Whole);
  const Measured& unknown = unknown_without_loss();
  EXPECT_EQ(whole.requested_percent, 100);
  EXPECT_LT(unknown.requested_percent, 50);
  EXPECT_LT(unknown.rays * 10, whole.rays * 7);
  EXPECT_NEAR(unknown.mask_error_percent, whole.mask_error_percent, 0.01);
  EXPECT_NEAR(unknown.psnr_db, whole.psnr_db, 0.1);
}

/// Errors are shares of the pixels that are seen, which are fewer, and most errors are in the middle. So the
/// shares are compared as numbers of errors: the lenses leave pi / 4 of the pixels.
TEST(PartialRequest, RoundLensesSaveRays) {
  const PerEye<HiddenArea> lenses = round_lenses(setup().head.fov);
  const Measured &whole = unknown_without_loss(), seen = measured("delay=25ms", Asks::Unknown, &lenses);
  RecordProperty("rays_percent",
                 std::to_string(100.0 * static_cast<double>(seen.rays) / static_cast<double>(whole.rays)));
  RecordProperty("asked_percent", std::to_string(whole.requested_percent));
  RecordProperty("asked_with_lenses_percent", std::to_string(seen.requested_percent));
  EXPECT_LT(seen.rays * 100, whole.rays * 93);
  EXPECT_LT(seen.requested_percent, 0.95 * whole.requested_percent);
  std::printf(
      "rays: %.1f %% of those without lenses; asked: %.1f and %.1f %%; mask error: %.3f and %.3f %%\n",
      100.0 * static_cast<double>(seen.rays) / static_cast<double>(whole.rays), whole.requested_percent,
      seen.requested_percent, whole.mask_error_percent, seen.mask_error_percent);
  EXPECT_LT(std::numbers::pi / 4 * seen.mask_error_percent, whole.mask_error_percent);
}

TEST(PartialRequest, AsksAgainForWhatWasLost) {
  const Measured &perfect = unknown_without_loss(), lossy = measured("delay=25ms,loss=5%", Asks::Unknown);
  EXPECT_GT(lossy.psnr_db, perfect.psnr_db - 0.5);
  EXPECT_LT(lossy.worst_unknown_percent, 1);
  EXPECT_NE(lossy.rays, perfect.rays) << "nothing was lost";
}

// All that is sent within 200 ms is lost. The first mask that was asked for afterwards is used one round trip
// and at most two frames later, with all of its tiles, and the picture then is as right as before.
TEST(PartialRequest, ABurstOfLossesIsOverOneRoundTripAndTwoFramesAfterIt) {
  constexpr Duration kWay = std::chrono::milliseconds(25), kPeriod = duration_from_ms(1e3 / 72);
  const Network network = network_from("delay=25ms,silence=200ms/1s").value();
  Play play{.device = setup().device,
            .scene = setup().scene,
            .head = setup().head,
            .size = {160, 160},
            .frames = 84,
            .reference_every = 1};
  play.request.every = 1;  // a still scene needs only every second request
  std::vector<double> unknown, error;
  play.watch = [&](const FrameView&, const FrameRecord& record, const MeasuredFrame*) {
    const auto& errors = record.errors.value();
    unknown.push_back(std::max(errors[0].unknown, errors[1].unknown));
    error.push_back(std::max(errors[0].mask_error, errors[1].mask_error));
  };
  const Played run = farshade::play(play, network);
  const Time ended(std::chrono::seconds(1));
  const auto after = std::ranges::find_if(run.frames, [&](const PlayedFrame& frame) {
    return frame.newest_asked >= ended && frame.tiles_current == 1;
  });
  ASSERT_NE(after, run.frames.end());
  EXPECT_LE(after->at - ended, 2 * kWay + 2 * kPeriod);
  const auto first = static_cast<std::size_t>(after - run.frames.begin());
  const double before = *std::max_element(error.begin() + 20, error.begin() + 55);
  for (std::size_t i = first; i < error.size(); ++i) {
    EXPECT_LE(unknown[i], 0.001) << "frame " << i;
    EXPECT_LE(error[i], 1.2 * before) << "frame " << i;
  }
}

}  // namespace
}  // namespace farshade
