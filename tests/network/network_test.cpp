// A complete run in virtual time over every named network. The run must continue, with bounded errors.
#include <gtest/gtest.h>

#include <numeric>

#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "tests/network/rehearsal.h"
#include "tests/support/test_place.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

/// The memory of lavapipe varies by up to this much with the view (90 to 105 MB over 900 frames).
constexpr std::size_t kDriverSwing_bytes = 48u << 20;
constexpr Duration kPeriod = Duration(1'000'000'000 / 72);

struct Setup {
  gpu::Device device = gpu::open_device({.name_contains = test_gpu()}).value();
  Scene scene = load_scene(asset("room.glb")).value();
  HeadRecording head = load_head_recording(asset("walk.csv"), {}).value();
};

/// Scene and device for all tests of this program.
const Setup& setup() {
  static const Setup shared;
  return shared;
}

Played played(const Network& network, std::uint32_t frames = 72, std::uint32_t reference_every = 0) {
  return play({.device = setup().device,
               .scene = setup().scene,
               .head = setup().head,
               .size = {64, 64},
               .frames = frames,
               .reference_every = reference_every},
              network);
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const Network& network : named_networks()) all.push_back(network.name);
  return all;
}

class OverNetwork : public testing::TestWithParam<std::string> {};

TEST_P(OverNetwork, EveryFrameIsShownAndNoneGoesBack) {
  const Network network = network_from(GetParam()).value();
  const bool slow = network.moves_every > 0s || network.model.silence > 0s;
  const std::uint32_t frames = slow ? 400 : 100;  // both repeat every 5 s
  const Played run = played(network, frames);
  EXPECT_EQ(run.frames.size(), frames);
  std::optional<FrameId> newest;
  for (const PlayedFrame& frame : run.frames) {
    if (!frame.newest) {
      EXPECT_FALSE(newest.has_value()) << "the client has lost its masks";
      continue;
    }
    EXPECT_TRUE(!newest || *newest == *frame.newest || is_newer(*frame.newest, *newest));
    newest = frame.newest;
  }
  EXPECT_EQ(newest.has_value(), network.model.loss < 1);
  EXPECT_LT(run.heap_peak[1], run.heap_peak[0] + kDriverSwing_bytes) << "memory does not grow";
}

INSTANTIATE_TEST_SUITE_P(Named, OverNetwork, testing::ValuesIn(names()), [](const auto& each) {
  std::string name = each.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(OverNetworkTwice, IsTheSameToTheLastBit) {
  const Network poor = network_from("poor").value();
  const Played a = played(poor, 60, 5), b = played(poor, 60, 5);
  EXPECT_EQ(a.worse_eye(&EyeErrors::mask_error), b.worse_eye(&EyeErrors::mask_error));
  EXPECT_EQ(a.worse_eye(&EyeErrors::psnr_db), b.worse_eye(&EyeErrors::psnr_db));
  EXPECT_EQ(a.client.assembler, b.client.assembler);
  EXPECT_EQ(a.client.port.sent_bytes, b.client.port.sent_bytes);
  EXPECT_EQ(a.client.port.received_bytes, b.client.port.received_bytes);
  for (std::size_t i = 0; i < a.frames.size(); ++i) EXPECT_EQ(a.frames[i].newest, b.frames[i].newest);
}

TEST(OverNetworkLoss, OfFivePercentLeavesFivePercentOfTilesToOlderMasks) {
  const Played run = played({"", {.delay = 25ms, .loss = 0.05}}, 200);
  EXPECT_GE(run.mean_of(&PlayedFrame::tiles_current), 0.945);
  EXPECT_LT(run.mean_of(&PlayedFrame::tiles_current), 0.97) << "nothing was lost";
  EXPECT_GE(run.mean_of(&PlayedFrame::tiles_recent), 0.98) << "the mask before has the missing tiles";
}

TEST(OverNetworkLoss, CostsLessThanADecibel) {
  const double clean = mean(played({"", {.delay = 25ms}}, 120, 4).worse_eye(&EyeErrors::psnr_db));
  for (const double burst : {1.0, 8.0}) {
    const Played lossy = played({"", {.delay = 25ms, .loss = 0.05, .burst = burst}}, 120, 4);
    EXPECT_GT(mean(lossy.worse_eye(&EyeErrors::psnr_db)), clean - 1.0) << "burst " << burst;
    EXPECT_GT(lossy.client.missing, 3u) << "nothing was lost";
  }
}

/// The frames of a run after its start, at 160 x 160 pixels per eye, over a path with this delay in each
/// direction.
struct Settled {
  double mask_error = 0, newest = 0;
};
Settled settled(Duration delay) {
  const Played run = play({.device = setup().device,
                           .scene = setup().scene,
                           .head = setup().head,
                           .size = {160, 160},
                           .frames = 96,
                           .reference_every = 3},
                          {"", {.delay = delay}});
  Settled result;
  std::size_t measured = 0;
  for (std::size_t i = 32; i < run.log.records().size(); ++i) {
    const FrameRecord& record = run.log.records()[i];
    if (!record.errors) continue;
    ++measured;
    for (const EyeErrors& eye : *record.errors) {
      result.mask_error += eye.mask_error / kEyes;
      result.newest += eye.newest / kEyes;
    }
  }
  result.mask_error /= static_cast<double>(measured);
  result.newest /= static_cast<double>(measured);
  std::printf("%lld ms: mask error %.4f %%, %.1f %% from the first mask\n",
              static_cast<long long>(delay / 1ms), result.mask_error * 100, result.newest * 100);
  return result;
}

// With 20 ms in each direction, a frame begins while the slices of an answer are arriving.
TEST(OverNetworkDelay, ShorterDelayIsNoWorse) {
  const Settled near = settled(20ms), far = settled(50ms);
  EXPECT_LE(near.mask_error, far.mask_error);
  EXPECT_GE(near.newest, far.newest - 0.01);
}

TEST(OverNetworkSilence, IsOverOneRoundTripAndTwoFramesAfterIt) {
  constexpr Duration kWay = 25ms;
  const Played run = played({"", {.delay = kWay, .silence = 2s, .silence_every = 5s}}, 400);
  const Time ended(5s);
  const auto first_after = std::find_if(run.frames.begin(), run.frames.end(), [&](const PlayedFrame& frame) {
    return frame.newest_asked >= ended;
  });
  ASSERT_NE(first_after, run.frames.end());
  EXPECT_LE(first_after->at - ended, 2 * kWay + 2 * kPeriod);
  EXPECT_EQ(run.client.sessions, 1u) << "the session survived";
}

TEST(OverNetworkMove, GoesOnAtTheNewAddress) {
  const Played run = played({"", {.delay = 5ms}, 2s}, 330);
  EXPECT_EQ(run.server.sessions.moved, 2u);
  EXPECT_EQ(run.client.sessions, 1u);
  for (std::size_t i = 40; i < run.frames.size(); ++i)
    EXPECT_LT(run.frames[i].at - *run.frames[i].newest_asked, 100ms) << "frame " << i;
}

TEST(OverNetworkRate, MasksComeLessOftenAndThenSmallerWhereThePathIsNarrow) {
  const Played wide = played({"", {.delay = 5ms}}, 200);
  const Played narrow = played({"", {.delay = 5ms, .rate_bytes_per_s = 60e3}}, 500);
  EXPECT_GT(wide.server.frames, 195u);
  EXPECT_LT(narrow.server.frames, 400u);
  EXPECT_GT(narrow.server.frames, 20u);
  for (std::size_t i = 300; i < narrow.frames.size(); ++i)
    ASSERT_LT(narrow.frames[i].at - *narrow.frames[i].newest_asked, 500ms) << "frame " << i;
}

}  // namespace
}  // namespace farshade
