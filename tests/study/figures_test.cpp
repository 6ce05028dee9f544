#include "tests/study/figures.h"

#include <gtest/gtest.h>

namespace farshade::study {
namespace {

TEST(Figures, TellMedianAndTheWorseSide) {
  Figures figures;
  for (int i = 0; i <= 100; ++i) {
    figures.add(Group::Error, "flip", i);
    figures.add(Group::Error, "psnr", i, Worse::Low);
  }
  const nlohmann::json told = figures.json();
  EXPECT_EQ(told["error"]["flip"],
            (nlohmann::json{{"median", 50.0}, {"p95", 95.0}, {"p99", 99.0}, {"count", 101}}));
  EXPECT_EQ(told["error"]["psnr"],
            (nlohmann::json{{"median", 50.0}, {"p95", 5.0}, {"p99", 1.0}, {"count", 101}}));
  EXPECT_FALSE(told.contains("time"));
}

EyeErrors eye(double mask_error, double psnr_db) {
  EyeErrors errors;
  errors.mask_error = mask_error;
  errors.psnr_db = psnr_db;
  return errors;
}

/// Two frames: one before the first answer, one with errors.
Played two_frames(const PerEye<EyeErrors>& errors) {
  Played played;
  const auto frame = [](std::uint32_t number) {
    FrameRecord record{.frame = {number},
                       .display_time = Time{},
                       .age = {},
                       .delta = {},
                       .times = {},
                       .guard_band = {},
                       .server = {},
                       .errors = {}};
    record.times.frame = std::chrono::milliseconds(number);
    return record;
  };
  FrameRecord first = frame(1), second = frame(2);
  first.start_up = true;
  first.errors = PerEye<EyeErrors>{eye(1, 1), eye(1, 1)};
  second.age = std::chrono::milliseconds(40);
  second.black = {0.25, 0.5};
  second.errors = errors;
  played.log.add(first);
  played.log.add(second);
  return played;
}

TEST(Figures, OfAFrameAreItsWorseEyesAndLeaveStartUpOut) {
  Figures figures;
  EyeErrors left = eye(0.25, 30), right = eye(0.5, 40);
  left.flip = 0.25, left.ssim = 0.75, left.other_surface = 0.125;
  right.flip = 0.125, right.ssim = 0.875, right.other_surface = 0.25;
  add_errors(two_frames({left, right}), 0, figures);
  const nlohmann::json told = figures.json();
  EXPECT_EQ(told["error"]["flip"]["median"], 0.25);
  EXPECT_EQ(told["error"]["ssim"]["median"], 0.75);
  EXPECT_EQ(told["error"]["other_surface"]["median"], 25.0);
  EXPECT_EQ(told["error"]["mask_error"]["median"], 50.0);
  EXPECT_EQ(told["error"]["mask_error"]["count"], 1);
  EXPECT_EQ(told["error"]["psnr"]["median"], 30.0);
  EXPECT_EQ(told["error"]["known"]["median"], 100.0);
  EXPECT_EQ(told["error"]["black"]["median"], 50.0);
  EXPECT_EQ(told["wire"]["latency"]["median"], 40.0);
}

TEST(Figures, LeaveOutWhatAPictureCannotTell) {
  Figures figures;
  constexpr double none = kNotMeasured;
  const EyeErrors picture{none, none, 20, none, none, none, none, none, none, none, none, std::nullopt};
  add_errors(two_frames({picture, picture}), 0, figures);
  const nlohmann::json told = figures.json();
  EXPECT_EQ(told["error"]["psnr"]["median"], 20.0);
  for (const char* name : {"mask_error", "known", "unknown", "from_newest"})
    EXPECT_FALSE(told["error"].contains(name)) << name;
}

TEST(Figures, AddUpAllStagesOfTheServerAfterTheWarmUp) {
  using std::chrono::milliseconds;
  Played played = two_frames({});
  for (const std::uint32_t frame : {1u, 2u, 3u}) {
    FrameReport report{.frame = {frame}, .slices = 4, .payload_bytes = 1000 * frame};
    report.primary = milliseconds(1), report.shadow = milliseconds(2), report.draw = milliseconds(4);
    report.pack = milliseconds(8 * frame);
    played.reports.push_back(report);
  }
  Figures figures;
  add_times(played, 2, figures);
  add_errors(played, 2, figures);
  const nlohmann::json told = figures.json();
  EXPECT_EQ(told["time"]["server_frame"],
            (nlohmann::json{{"median", 31.0}, {"p95", 31.0}, {"p99", 31.0}, {"count", 1}}));
  EXPECT_EQ(told["wire"]["answer_bytes"]["median"], 3000.0);
  EXPECT_EQ(told["wire"]["answer_datagrams"]["median"], 5.0) << "its report is one";
  EXPECT_FALSE(told["time"].contains("client_frame")) << "both frames are warm-up";
}

TEST(WarmUp, FollowsDelayAndRefreshRate) {
  using std::chrono::milliseconds;
  constexpr auto masks = 2 * static_cast<std::uint32_t>(kMaxMasks);  // in a still scene, 28 ms apart
  EXPECT_EQ(warm_up_frames({}, 72), masks);
  EXPECT_EQ(warm_up_frames({.delay = milliseconds(50)}, 72), 8 + masks) << "7.2 frames";
  EXPECT_EQ(warm_up_frames({.delay = milliseconds(100)}, 72), 15 + masks) << "14.4 frames";
  EXPECT_EQ(warm_up_frames({.delay = milliseconds(50)}, 90), 9 + masks / 2 * 3);
  EXPECT_EQ(warm_up_frames({.delay = milliseconds(40), .jitter = milliseconds(10)}, 72), 8 + masks);
}

TEST(WarmUp, OfModesThatRequestNothingIsTheSameOnEveryNetwork) {
  const LinkModel slow{.delay = std::chrono::milliseconds(50)};
  for (const Mode mode : {Mode::Local, Mode::Full})
    EXPECT_EQ(warm_up_frames(awaited(mode, slow), 72), warm_up_frames({}, 72));
  for (const Mode mode :
       {Mode::Hybrid, Mode::ClientPositions, Mode::ServerGBuffer, Mode::Remote, Mode::Delta})
    EXPECT_EQ(awaited(mode, slow).delay, slow.delay);
}

/// A run of `frames` frames whose first answer is shown in frame `answered` (from 0). Frame i takes i + 1 ms.
Played run_of(std::uint32_t frames, std::uint32_t answered) {
  Played played;
  for (std::uint32_t i = 0; i < frames; ++i) {
    FrameRecord record{.frame = {i + 1},
                       .display_time = Time{},
                       .age = {},
                       .delta = {},
                       .times = {},
                       .guard_band = {},
                       .server = {},
                       .errors = {}};
    record.start_up = i < answered;
    record.times.frame = std::chrono::milliseconds(i + 1);
    played.log.add(record);
    played.frames.push_back({.at = Time{}, .pipelines = 4});
  }
  return played;
}

TEST(WarmUp, StartsAtTheFirstFrameWithAnAnswer) {
  EXPECT_EQ(first_timed_frame(run_of(40, 8), 12), 20u);
  EXPECT_EQ(first_timed_frame(run_of(40, 15), 19), 34u);
  EXPECT_EQ(first_timed_frame(run_of(40, 0), 4), 4u) << "a mode without a server";
  EXPECT_EQ(first_timed_frame(run_of(40, 30), 19), 40u) << "the run ends before the warm-up";
  EXPECT_EQ(first_timed_frame(run_of(40, 40), 4), 40u) << "no answer";
}

TEST(WarmUp, LeavesOutFramesThatCompileAPipeline) {
  Played played = run_of(10, 2);
  for (std::size_t i = 0; i < 10; ++i) played.frames[i].pipelines = i < 5 ? i : i < 8 ? 5 : 6;
  Figures figures;
  add_times(played, first_timed_frame(played, 2), figures);  // 4 and 5 compile, 8 compiles
  const nlohmann::json frame = figures.json()["time"]["client_frame"];
  EXPECT_EQ(frame["count"], 3) << "frames 6, 7 and 9; 4, 5 and 8 compile";
  EXPECT_EQ(frame["median"], 8.0);
}

}  // namespace
}  // namespace farshade::study
