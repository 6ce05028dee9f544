#include "vr_client/preview/preview_runtime.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "stereo/math/rotation.h"
#include "tests/support/manual_clock.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Time kNow = time_from_ns(5'000'000'077);
constexpr Duration kPeriod = 10ms;

/// A pacer with given frame times, on a clock that only frames and waiting advance.
struct PacerBench {
  FramePacer pacer{100};
  Time now = kNow;

  FrameTiming frame(Duration takes) {
    now = std::max(now, pacer.next_begin(now));
    const FrameTiming timing = pacer.begin(now);
    now += takes;
    pacer.learn(takes);
    return timing;
  }
  void frames(int count, Duration takes) {
    for (int i = 0; i < count; ++i) frame(takes);
  }
  /// The number of display periods that the next frame takes.
  [[nodiscard]] std::int64_t periods() const {
    FramePacer next = pacer;
    return next.begin(now).period / kPeriod;
  }
};

TEST(FramePacer, GivesFastFramesEveryDisplayTime) {
  PacerBench bench;
  for (int i = 1; i <= 50; ++i) {
    const FrameTiming timing = bench.frame(7ms);
    EXPECT_EQ(timing.display_time, kNow + i * kPeriod);
    EXPECT_EQ(timing.period, kPeriod);
  }
}

TEST(FramePacer, DoesNotDriftOverADay) {
  FramePacer pacer(72);
  Time now = kNow;
  (void)pacer.begin(now);
  now += 24h;
  EXPECT_EQ(pacer.begin(now).display_time, kNow + 24h + 13'888'889ns);
}

TEST(FramePacer, GivesSlowFramesTheWholePeriodsTheyNeed) {
  struct Case {
    Duration takes;
    std::int64_t periods;
  };
  for (const Case c :
       {Case{1ms, 1}, Case{10ms, 1}, Case{11ms, 2}, Case{20ms, 2}, Case{33ms, 4}, Case{95ms, 10}}) {
    PacerBench bench;
    bench.frames(20, c.takes);
    EXPECT_EQ(bench.periods(), c.periods) << ms_of(c.takes);
    const FrameTiming one = bench.frame(c.takes);
    const FrameTiming next = bench.frame(c.takes);
    EXPECT_EQ(one.period, c.periods * kPeriod);
    EXPECT_EQ(next.display_time - one.display_time, one.period)
        << "the display time follows the stated interval";
  }
}

/// With two frames in flight a frame begins in each period, and its picture is ready two periods later.
TEST(FramePacer, ShowsFramesInFlightWhenTheyAreReady) {
  PacerBench bench;
  FrameTiming last = bench.frame(8ms);
  for (std::size_t i = 0; i < 40; ++i) {
    bench.pacer.learn_ready(17ms);
    const FrameTiming timing = bench.frame(8ms);
    EXPECT_EQ(timing.period, kPeriod) << i;
    EXPECT_GT(timing.display_time, last.display_time) << i;
    if (i >= FramePacer::kRemembered) {
      EXPECT_EQ(timing.display_time - (bench.now - 8ms), 2 * kPeriod) << i;
    }
    last = timing;
  }
  for (std::size_t i = 0; i < FramePacer::kRemembered; ++i) {
    bench.pacer.learn_ready(7ms);
    static_cast<void>(bench.frame(8ms));
  }
  const FrameTiming timing = bench.frame(8ms);
  EXPECT_EQ(timing.display_time - (bench.now - 8ms), kPeriod) << "and falls back";
}

TEST(FramePacer, IgnoresAFewLateFrames) {
  PacerBench bench;
  for (int i = 0; i < 100; ++i) {
    bench.frame(i % 6 == 0 ? 47ms : 8ms);
    EXPECT_EQ(bench.periods(), 1);
  }
}

TEST(FramePacer, ReactsToALateFrameInThree) {
  PacerBench bench;
  for (int i = 0; i < 18; ++i) bench.frame(i % 3 == 0 ? 28ms : 8ms);
  EXPECT_EQ(bench.periods(), 3);
}

TEST(FramePacer, IgnoresASlowFirstFrame) {
  PacerBench bench;
  bench.frame(900ms);
  EXPECT_EQ(bench.frame(8ms).period, kPeriod);
}

TEST(FramePacer, FollowsChangesWithin16Frames) {
  PacerBench bench;
  bench.frames(16, 8ms);
  bench.frames(16, 28ms);
  EXPECT_EQ(bench.periods(), 3);
  bench.frames(16, 8ms);
  EXPECT_EQ(bench.periods(), 1);
}

TEST(FramePacer, DoesNotOscillateAtALimit) {
  constexpr unsigned seed = 20;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::int64_t> takes_us(19'200, 20'800);
  PacerBench bench;
  bench.frames(32, 20'500us);
  ASSERT_EQ(bench.periods(), 3);
  for (int i = 0; i < 500; ++i) {
    bench.frame(std::chrono::microseconds(takes_us(random)));
    EXPECT_EQ(bench.periods(), 3) << i;
  }
  bench.frames(16, 17'900us);
  EXPECT_EQ(bench.periods(), 2) << "enough room to fall";
}

TEST(FramePacer, DisplayTimesIncreaseByWholePeriods) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::exponential_distribution<double> hitch_ms(1.0 / 25);
    PacerBench bench;
    Time last = kNow;
    for (int i = 0; i < 2000; ++i) {
      const FrameTiming timing = bench.frame(i % 300 < 100 ? 3ms : duration_from_ms(hitch_ms(random)));
      ASSERT_GT(timing.display_time, last);
      EXPECT_EQ((timing.display_time - kNow) % kPeriod, 0ns);
      EXPECT_EQ(timing.period % kPeriod, 0ns);
      EXPECT_GE(timing.display_time - last, timing.period);
      last = timing.display_time;
    }
  }
}

TEST(FramePacer, ALateFrameBeginsAtOnceOrAtTheNearestGridPoint) {
  for (const auto& [late, begins] : {std::pair<Duration, Duration>{4ms, 14ms}, {6ms, 20ms}}) {
    FramePacer pacer(100);
    (void)pacer.begin(kNow);
    const Time now = kNow + kPeriod + late;
    EXPECT_EQ(std::max(now, pacer.next_begin(now)), kNow + begins);
  }
}

TEST(FramePacerDeathTest, RefusesAnInvalidRefreshRate) {
  EXPECT_DEATH(FramePacer(0), "refresh rate");
  EXPECT_DEATH(FramePacer(NAN), "refresh rate");
}

/// The head moves 1 m to the right in one second, and turns left by 1 rad.
HeadRecording walk() {
  HeadRecording recording;
  recording.samples.push_back({kNow, {glm::dquat(1, 0, 0, 0), {0, 1.6, 0}}});
  recording.samples.push_back({kNow + 1s, {rotation_exp({0, 1, 0}), {1, 1.6, 0}}});
  return recording;
}

constexpr Rigid<Stage, Head> kStart{glm::dquat(1, 0, 0, 0), {0, 1.7, 5}};

/// A runtime at 100 Hz with its own clock. `controls` is the result of its callback.
struct Desk {
  HeadRecording recording = walk();
  ManualClock clock;
  std::vector<Duration> slept;
  std::optional<HeadControls> controls = HeadControls{};
  Duration taking_in{};
  PreviewSetup setup{.start = kStart,
                     .recording = PlacedHeadRecording{recording, {glm::dquat(1, 0, 0, 0), {0, 0, 50}}},
                     .refresh_hz = 100,
                     .frames = {}};
  std::optional<PreviewRuntime> runtime;

  PreviewRuntime& open() {
    clock.advance_to(kNow);
    runtime.emplace(
        setup, clock,
        [this](Duration span) {
          slept.push_back(span);
          clock.advance_to(clock.now() + span);
        },
        [this] {
          clock.advance_to(clock.now() + taking_in);
          return controls;
        });
    return *runtime;
  }
  FrameTiming frame(Duration takes) {
    const FrameTiming timing = runtime->wait_frame().value();
    runtime->end_frame(timing.display_time);
    clock.advance_to(clock.now() + takes);
    return timing;
  }
  [[nodiscard]] glm::dvec3 head() const { return runtime->stage_from_head().translation; }
};

TEST(PreviewRuntime, SleepsUntilTheFrameShouldBegin) {
  Desk desk;
  desk.open();
  desk.frame(3ms);
  desk.frame(9ms);
  desk.frame(3ms);
  EXPECT_EQ(desk.slept, (std::vector<Duration>{7ms, 1ms}));
  EXPECT_EQ(desk.clock.now(), kNow + 23ms);
}

TEST(PreviewRuntime, EndsAfterTheRequestedFrames) {
  Desk desk;
  desk.setup.frames = 2;
  PreviewRuntime& runtime = desk.open();
  EXPECT_TRUE(runtime.wait_frame());
  EXPECT_TRUE(runtime.wait_frame());
  EXPECT_FALSE(runtime.wait_frame());
  EXPECT_FALSE(runtime.wait_frame()) << "there are no frames after the end";
}

TEST(PreviewRuntime, EndsWhenTheCallbackReturnsNothing) {
  Desk desk;
  PreviewRuntime& runtime = desk.open();
  EXPECT_TRUE(runtime.wait_frame());
  desk.controls.reset();
  EXPECT_FALSE(runtime.wait_frame());
}

TEST(PreviewRuntime, NoDisplayTimeRepeatsAfterLateFrames) {
  constexpr unsigned seed = 8;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::exponential_distribution<double> hitch_ms(1.0 / 15);
  Desk desk;
  desk.open();
  Time last = kNow;
  for (int i = 0; i < 1000; ++i) {
    desk.taking_in = duration_from_ms(i % 50 == 0 ? 300 : 0.2);
    const FrameTiming timing = desk.frame(duration_from_ms(hitch_ms(random)));
    ASSERT_GE(timing.display_time - last, timing.period);
    ASSERT_GE(timing.period, kPeriod);
    last = timing.display_time;
  }
}

TEST(PreviewRuntime, StatesTheTrueFrameInterval) {
  Desk desk;
  desk.open();
  for (int i = 0; i < 20; ++i) desk.frame(38ms);
  const FrameTiming one = desk.frame(38ms);
  const FrameTiming next = desk.frame(38ms);
  EXPECT_EQ(one.period, 40ms);
  EXPECT_EQ(next.display_time - one.display_time, 40ms);
}

TEST(PreviewRuntime, WaitingInAMinimisedWindowIsNotFrameTime) {
  Desk desk;
  desk.open();
  desk.taking_in = 100ms;
  for (int i = 0; i < 20; ++i) desk.frame(2ms);
  desk.taking_in = 0ms;
  EXPECT_EQ(desk.frame(2ms).period, kPeriod);
}

TEST(PreviewRuntime, SimulatedHeadMovesByDisplayTime) {
  Desk desk;
  desk.controls->head.walk = {0, 0, -1};
  desk.open();
  desk.frame(3ms);
  EXPECT_EQ(desk.head(), kStart.translation) << "no time has passed";
  desk.frame(3ms);
  EXPECT_NEAR(desk.head().z, 5 - 0.014, 1e-12);
  desk.frame(27ms);
  desk.frame(3ms);
  EXPECT_NEAR(desk.head().z, 5 - 0.070, 1e-12) << "two frames, 10 ms and 30 ms long";
}

TEST(PreviewRuntime, SimulatedHeadHasOnePoseForAllTimes) {
  Desk desk;
  desk.controls->head = {.turn_px = {40, 0}, .walk = {0, 0, -1}};
  PreviewRuntime& runtime = desk.open();
  desk.frame(3ms);
  const Time shown = desk.frame(3ms).display_time;
  EXPECT_EQ(runtime.locate_views(shown), runtime.locate_views(shown + 100ms));
  EXPECT_EQ(runtime.locate_views(shown), views_of(runtime.stage_from_head(), desk.controls->headset));
}

TEST(PreviewRuntime, UsesTheHeadsetOfTheFrame) {
  Desk desk;
  PreviewRuntime& runtime = desk.open();
  for (const double eye_distance_m : {0.063, 0.0, 0.2}) {
    const EyeFov fov = field_of_view(1 + eye_distance_m, 1.5);
    desk.controls->headset = {.eye_distance_m = eye_distance_m, .fov = {fov, fov}, .eye_size = {96, 64}};
    const Time shown = desk.frame(3ms).display_time;
    EXPECT_EQ(runtime.locate_views(shown), views_of(kStart, desk.controls->headset));
  }
}

TEST(PreviewRuntime, ARecordingMovesTheHeadByDisplayTime) {
  Desk desk;
  desk.controls->source = HeadSource::Recording;
  PreviewRuntime& runtime = desk.open();
  const Time first = desk.frame(3ms).display_time;
  EXPECT_EQ(desk.head(), glm::dvec3(0, 1.6, 50));
  runtime.player()->set_speed(2);
  Time shown = first;
  while (shown < first + 300ms) shown = desk.frame(3ms).display_time;
  EXPECT_NEAR(desk.head().x, 0.6, 1e-9);
  const double ahead_m = runtime.locate_views(shown + 50ms)[0].stage_from_eye.translation.x -
                         views_of(runtime.stage_from_head(), {})[0].stage_from_eye.translation.x;
  EXPECT_NEAR(ahead_m, 0.1, 0.005) << "a recording knows its future";
  runtime.player()->scrub(900ms);
  for (int i = 0; i < 20; ++i) desk.frame(3ms);
  EXPECT_NEAR(desk.head().x, 1, 1e-9) << "holds its last pose";
}

TEST(PreviewRuntime, SimulatedHeadContinuesFromTheRecording) {
  Desk desk;
  desk.controls->source = HeadSource::Recording;
  PreviewRuntime& runtime = desk.open();
  for (int i = 0; i < 40; ++i) desk.frame(3ms);
  const Rigid<Stage, Head> left = runtime.stage_from_head();
  EXPECT_NEAR(left.translation.x, 0.39, 1e-9);

  desk.controls->source = HeadSource::Simulated;
  desk.frame(3ms);
  EXPECT_EQ(runtime.stage_from_head().translation, left.translation);
  EXPECT_LT(angle_between_rad(runtime.stage_from_head().rotation, left.rotation), 1e-12);
  desk.controls->head.walk = {0, 1, 0};
  desk.frame(3ms);
  EXPECT_NEAR(desk.head().y, 1.614, 1e-12);

  desk.controls->source = HeadSource::Recording;
  desk.frame(3ms);
  EXPECT_NEAR(desk.head().x, 0.40, 1e-9) << "the recording stood still meanwhile";
  EXPECT_NEAR(desk.head().y, 1.6, 1e-9);
}

TEST(PreviewRuntime, UsesTheSimulatedHeadWithoutARecording) {
  Desk desk;
  desk.setup.recording.reset();
  desk.controls->source = HeadSource::Recording;
  PreviewRuntime& runtime = desk.open();
  desk.frame(3ms);
  EXPECT_EQ(desk.head(), kStart.translation);
  EXPECT_EQ(runtime.player(), nullptr);
}

TEST(PreviewRuntimeDeathTest, ViewsNeedAFrame) {
  Desk desk;
  PreviewRuntime& runtime = desk.open();
  EXPECT_DEATH((void)runtime.locate_views(kNow), "frame has begun");
}

}  // namespace
}  // namespace farshade
