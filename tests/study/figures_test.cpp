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

/// Two frames: one before anything had come, one with errors.
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
  add_errors(two_frames({eye(0.25, 30), eye(0.5, 40)}), 0, figures);
  const nlohmann::json told = figures.json();
  EXPECT_EQ(told["error"]["mask_error"]["median"], 50.0);
  EXPECT_EQ(told["error"]["mask_error"]["count"], 1);
  EXPECT_EQ(told["error"]["psnr"]["median"], 30.0);
  EXPECT_EQ(told["error"]["known"]["median"], 100.0);
  EXPECT_EQ(told["error"]["black"]["median"], 50.0);
  EXPECT_EQ(told["wire"]["latency"]["median"], 40.0);
}

TEST(Figures, LeaveOutWhatAPictureCannotTell) {
  Figures figures;
  const EyeErrors picture = picture_errors(20);
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

}  // namespace
}  // namespace farshade::study
