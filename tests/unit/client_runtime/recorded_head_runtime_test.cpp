#include "vr_client/runtime/recorded_head_runtime.h"

#include <gtest/gtest.h>

#include "stereo/math/rotation.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Time kStart = time_from_ns(7'000'000'123);

/// A recording of one second, in which the head moves 2 m ahead and turns left by 90 degrees.
HeadRecording walk() {
  HeadRecording recording{.samples = {}, .eye_distance_m = 0.07, .fov = {}};
  recording.samples.push_back({kStart, {glm::dquat(1, 0, 0, 0), {0, 1.6, 0}}});
  recording.samples.push_back({kStart + 1s, {rotation_exp({0, 1.57079632679, 0}), {0, 1.6, -2}}});
  recording.fov = {EyeFov{-0.9, 0.7, 0.6, -0.5}, EyeFov{-0.7, 0.9, 0.6, -0.5}};
  return recording;
}

HeadPlayback playback(double refresh_hz, Duration skip = {}, std::optional<std::uint32_t> frames = {}) {
  return {.stage_from_recorded = {},
          .eye_size = {96, 64},
          .refresh_hz = refresh_hz,
          .skip = skip,
          .frames = frames};
}

std::vector<Time> display_times(RecordedHeadRuntime& runtime) {
  std::vector<Time> times;
  while (const auto timing = runtime.wait_frame()) {
    times.push_back(timing->display_time);
    runtime.end_frame(timing->display_time);
  }
  return times;
}

TEST(RecordedHeadRuntime, GivesEveryDisplayTimeOfTheRecording) {
  const HeadRecording recording = walk();
  RecordedHeadRuntime runtime(recording, playback(72));
  EXPECT_EQ(frame_count(recording, playback(72)), 73u);
  const std::vector<Time> times = display_times(runtime);
  ASSERT_EQ(times.size(), 73u);
  EXPECT_EQ(times[0], recording.start());
  EXPECT_EQ(times[1], recording.start() + 13'888'889ns);
  EXPECT_EQ(times[72], recording.end()) << "no drift: each time is rounded on its own";
  EXPECT_EQ(runtime.skipped(), 0u);
}

TEST(RecordedHeadRuntime, CountsNoMoreFramesThanANumberHolds) {
  HeadRecording recording = walk();
  recording.samples.front().time = Time{};
  recording.samples.back().time = time_from_ns(std::int64_t{1} << 62);  // 146 years
  EXPECT_EQ(frame_count(recording, playback(72)), std::numeric_limits<std::uint32_t>::max());
  EXPECT_EQ(frame_count(recording, playback(72, {}, 5)), 5u);
}

TEST(RecordedHeadRuntime, StatesThePeriod) {
  const HeadRecording recording = walk();
  RecordedHeadRuntime runtime(recording, playback(90));
  EXPECT_EQ(runtime.wait_frame()->period, 11'111'111ns);
}

TEST(RecordedHeadRuntime, SkipsTheBeginningAndStopsAfterTheFramesAskedFor) {
  const HeadRecording recording = walk();
  RecordedHeadRuntime runtime(recording, playback(10, 250ms, 3));
  EXPECT_EQ(frame_count(recording, playback(10, 250ms, 3)), 3u);
  EXPECT_EQ(display_times(runtime), (std::vector<Time>{kStart + 250ms, kStart + 350ms, kStart + 450ms}));
  EXPECT_FALSE(runtime.wait_frame().has_value()) << "there are no frames after the end";
}

TEST(RecordedHeadRuntime, EndsWithTheRecordingHoweverManyFramesAreAskedFor) {
  const HeadRecording recording = walk();
  EXPECT_EQ(frame_count(recording, playback(10, 800ms, 1000)), 3u);
}

TEST(RecordedHeadRuntime, RealTimeShowsOrCountsEveryDisplayTime) {
  const HeadRecording recording = walk();
  HeadPlayback fast = playback(1000, 990ms);
  fast.pace = Pace::Real;
  RecordedHeadRuntime runtime(recording, fast);
  const Stopwatch watch;
  const std::vector<Time> times = display_times(runtime);
  EXPECT_GE(watch.elapsed(), 10ms);
  EXPECT_EQ(times.size() + runtime.skipped(), frame_count(recording, fast));
  EXPECT_EQ(times.front(), kStart + 990ms) << "the clock begins with the first frame";
  EXPECT_EQ(times.back(), recording.end()) << "the last frame is shown even if it is late";
}

TEST(RecordedHeadRuntime, EyesAreOneEyeDistanceApartLeftEyeOnTheLeft) {
  const HeadRecording recording = walk();
  RecordedHeadRuntime runtime(recording, playback(72));
  for (const Duration after : {0ms, 300ms, 1000ms}) {
    const StereoView views = runtime.locate_views(kStart + after);
    const Point<Stage> right{views[1].stage_from_eye.translation};
    const Point<Eye> right_in_left = inverse(views[0].stage_from_eye)(right);
    EXPECT_LT(glm::length(right_in_left.v - glm::dvec3(0.07, 0, 0)), 1e-12) << after.count();
  }
}

TEST(RecordedHeadRuntime, EachEyeHasItsOwnFovAndTheSizeAskedFor) {
  const HeadRecording recording = walk();
  const StereoView views = RecordedHeadRuntime(recording, playback(72)).locate_views(kStart);
  EXPECT_EQ(views[0].fov, recording.fov[0]);
  EXPECT_EQ(views[1].fov, recording.fov[1]);
  EXPECT_NE(views[0].fov, views[1].fov);
  for (const View& view : views) EXPECT_EQ(view.size, (Extent{96, 64}));
}

TEST(RecordedHeadRuntime, CarriesTheRecordingToItsPlaceInTheStage) {
  const HeadRecording recording = walk();
  const Rigid<Stage, Recorded> placed{rotation_exp({0, -1.57079632679, 0}), {100, 0, 50}};
  HeadPlayback elsewhere = playback(72);
  elsewhere.stage_from_recorded = placed;
  RecordedHeadRuntime runtime(recording, elsewhere);
  const StereoView views = runtime.locate_views(kStart + 500ms);
  const glm::dvec3 head = (views[0].stage_from_eye.translation + views[1].stage_from_eye.translation) * 0.5;
  EXPECT_LT(glm::length(head - glm::dvec3(101, 1.6, 50)), 1e-9) << "ahead was turned to +x";
  EXPECT_NEAR(heading_rad(views[0].stage_from_eye.rotation), -1.57079632679 / 2, 1e-9);
}

}  // namespace
}  // namespace farshade
