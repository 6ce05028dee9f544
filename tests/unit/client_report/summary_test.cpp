#include "vr_client/report/summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace farshade {
namespace {

using namespace std::chrono_literals;

/// A frame that has a value of every figure.
FrameRecord full_record() {
  FrameRecord frame{.frame = {1}, .display_time = Time(1s)};
  frame.age = 30ms;
  frame.delta = PoseDelta{.traced_from_shown = {}, .angle_rad = 0.1, .distance_m = 0.2, .age = 20ms};
  frame.times.frame = 12ms;
  frame.times.gbuffer = 3ms;
  frame.guard_band = 0.25;
  frame.server = FrameReport{.primary = 2ms, .shadow = 3ms};
  frame.requested = 0.5;
  frame.cube_mask = CubeMaskCost{.rays = 9, .bytes = 8, .server = 1ms};
  frame.traffic = LinkTraffic{.up = 100, .down = 2000};
  frame.errors = PerEye<EyeErrors>{};
  for (EyeErrors& errors : *frame.errors)
    errors = {.mask_error = 0.01, .psnr_db = 30, .newest = 1, .unmoved_error = 0.02, .covered = 1};
  for (EyeErrors& errors : *frame.errors) errors.flip = 0.1, errors.ssim = 0.9, errors.other_surface = 0.01;
  (*frame.errors)[1].psnr_db = 29;
  return frame;
}

FrameLog log_of_full_records() {
  FrameLog log;
  for (int i = 0; i < 4; ++i) log.add(full_record());
  return log;
}

TEST(SummaryTable, NamesEachGroupOnceAndTheWorseEyeAlone) {
  const std::string text = table(log_of_full_records(), Mode::Hybrid);
  for (const std::string group :
       {"\nclient\n", "\nserver\n", "\nwire\n", "\nhead\n", "\nright eye (the worse one)\n"}) {
    const std::size_t first = text.find(group);
    ASSERT_NE(first, std::string::npos) << group << text;
    EXPECT_EQ(text.find(group, first + 1), std::string::npos) << group << text;
  }
  EXPECT_EQ(text.find("left eye"), std::string::npos) << text;
}

TEST(SummaryTable, HasTheRowsOfTheModeWithoutThoseThatAreZero) {
  const std::string hybrid = table(log_of_full_records(), Mode::Hybrid);
  EXPECT_NE(hybrid.find("\n  from newest mask, %                  100.000"), std::string::npos) << hybrid;
  EXPECT_NE(hybrid.find("asked for"), std::string::npos) << hybrid;
  for (const char* zero_or_other : {"unknown", "stale", "turn,", "shadow maps", "triangles", "datagrams"})
    EXPECT_EQ(hybrid.find(zero_or_other), std::string::npos) << hybrid;
  const std::string local = table(log_of_full_records(), Mode::Local);
  for (const char* of_server : {"server", "wire", "newest", "asked"})
    EXPECT_EQ(local.find(of_server), std::string::npos) << local;
  EXPECT_NE(local.find("PSNR, dB"), std::string::npos) << local;
  EXPECT_LT(local.size(), hybrid.size());
}

TEST(SummaryJson, HasEveryFigureWithUnitAndDefinition) {
  const RunSetting setting{.scene = "room.glb", .device = "a device", .head = "walk.csv"};
  const RunTotals totals{.period = 10ms, .frames = 4, .silent = 1500ms};
  const auto json = nlohmann::json::parse(summary_json(setting, totals, log_of_full_records()));
  ASSERT_EQ(json["figures"].size(), figures().size());
  for (std::size_t i = 0; i < figures().size(); ++i) {
    const auto& found = json["figures"][i];
    EXPECT_EQ(found["name"], figures()[i].text.name);
    EXPECT_EQ(found["group"], figures()[i].group());
    EXPECT_EQ(found["unit"], figures()[i].text.unit);
    EXPECT_EQ(found["meaning"], figures()[i].text.meaning);
    EXPECT_EQ(found["frames"], 4);
    EXPECT_TRUE(found["median"].is_number()) << found;
  }
  EXPECT_EQ(json["figures"][0]["median"], 12.0);
  ASSERT_EQ(json["run"].size(), run_figures().size());
  const auto silent =
      std::ranges::find_if(json["run"], [](const auto& f) { return f["name"] == "silent time"; });
  ASSERT_NE(silent, json["run"].end());
  EXPECT_EQ((*silent)["value"], 1.5);
  EXPECT_EQ((*silent)["unit"], "s");
  EXPECT_EQ(json["setting"]["mode"], "hybrid");
  EXPECT_EQ(json["setting"]["scene"], "room.glb");
}

TEST(SummaryJson, HasTheVerdict) {
  const RunTotals totals{.period = 10ms, .frames = 4};
  const auto verdict = nlohmann::json::parse(summary_json({}, totals, log_of_full_records()))["verdict"];
  EXPECT_EQ(verdict["fits"], false);
  EXPECT_EQ(verdict["client"]["median_ms"], 12.0);
  EXPECT_EQ(verdict["client"]["budget_ms"], 10.0);
  EXPECT_EQ(verdict["client"]["late_percent"], 100.0);
  EXPECT_EQ(verdict["server"]["fits"], true);
  EXPECT_EQ(verdict["picture"]["worse_eye"], "right");
  EXPECT_EQ(verdict["picture"]["psnr_db_median"], 29.0);
  EXPECT_EQ(verdict["bytes"]["down_bytes_a_frame"], 2000.0);
}

TEST(SummaryJson, SaysThatThereIsNoValue) {
  const auto json = nlohmann::json::parse(summary_json({.pace = Pace::Real}, {.period = 10ms}, FrameLog()));
  for (const char* part : {"picture", "client", "server", "bytes"})
    EXPECT_TRUE(json["verdict"][part].is_null()) << part;
  EXPECT_TRUE(json["setting"]["delay_ms"].is_null()) << "a real clock sets no delay";
  EXPECT_TRUE(json["figures"].empty());
}

}  // namespace
}  // namespace farshade
