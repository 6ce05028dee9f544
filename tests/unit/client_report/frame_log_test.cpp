#include "vr_client/report/frame_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <sstream>
#include <tuple>

namespace farshade {
namespace {

using namespace std::chrono_literals;

FrameRecord record(std::uint32_t frame) {
  FrameRecord made{
      .frame = {frame},
      .display_time = Time(frame * 10ms),
      .age = 30ms,
      .delta =
          PoseDelta{
              .traced_from_shown = {}, .angle_rad = 1e-3 * frame, .distance_m = 2e-3 * frame, .age = 20ms},
      .times = {},
      .guard_band = 0.25,
      .server = {},
      .errors = {}};
  made.times.frame = frame * 1ms;
  made.errors = PerEye<EyeErrors>{};
  for (EyeErrors& errors : *made.errors)
    errors = {
        .mask_error = 0.001 * frame, .psnr_db = 20.0 + frame, .newest = 1, .unmoved_error = 0.002 * frame};
  return made;
}

/// Frames 1 to 101, so that the percentiles are values of frames.
FrameLog full_log() {
  FrameLog log;
  for (std::uint32_t frame = 1; frame <= 101; ++frame) log.add(record(frame));
  return log;
}

const SummaryRow* row(const std::vector<SummaryRow>& rows, const std::string& group,
                      const std::string& metric) {
  const auto found = std::ranges::find_if(
      rows, [&](const SummaryRow& r) { return r.figure->group() == group && r.figure->text.name == metric; });
  return found == rows.end() ? nullptr : &*found;
}

std::vector<std::vector<std::string>> cells(const std::string& csv) {
  std::vector<std::vector<std::string>> table;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    table.emplace_back();
    std::istringstream fields(line + ",");
    for (std::string field; std::getline(fields, field, ',');) table.back().push_back(field);
  }
  return table;
}

TEST(FrameLog, PercentilesPointToTheWorseSide) {
  const auto rows = full_log().summary();
  const SummaryRow* time = row(rows, "client", "frame");
  ASSERT_NE(time, nullptr);
  EXPECT_EQ(time->spread.count, 101u);
  EXPECT_DOUBLE_EQ(time->spread.median, 51);
  EXPECT_DOUBLE_EQ(time->spread.p95, 96);
  EXPECT_DOUBLE_EQ(time->spread.p99, 100);
  const SummaryRow* error = row(rows, "left eye", "mask error");
  ASSERT_NE(error, nullptr);
  EXPECT_EQ(error->figure->text.unit, "%");
  EXPECT_NEAR(error->spread.p95, 9.6, 1e-9);
  const SummaryRow* psnr = row(rows, "right eye", "PSNR");
  ASSERT_NE(psnr, nullptr);
  EXPECT_DOUBLE_EQ(psnr->spread.median, 71);
  EXPECT_DOUBLE_EQ(psnr->spread.p95, 26) << "a low PSNR is worse";
  EXPECT_DOUBLE_EQ(psnr->spread.p99, 22);
}

TEST(FrameLog, HasThePoseDifferenceToTheTracedView) {
  const auto rows = full_log().summary();
  EXPECT_DOUBLE_EQ(row(rows, "wire", "staleness")->spread.median, 20);
  EXPECT_DOUBLE_EQ(row(rows, "wire", "age")->spread.median, 30);
  EXPECT_NEAR(row(rows, "head", "turned since traced view")->spread.median, 0.051 * 180 / std::numbers::pi,
              1e-9);
  EXPECT_NEAR(row(rows, "head", "moved since traced view")->spread.p95, 2 * 96, 1e-9) << "millimetres";
  EXPECT_DOUBLE_EQ(row(rows, "head", "guard band")->spread.median, 25);
}

TEST(FrameLog, AViewThatWasPredictedTooFarAheadIsAsStaleAsOneThatIsTooOld) {
  FrameLog log;
  for (const Duration age : {-3ms, -2ms, 2ms}) {
    FrameRecord made = record(1);
    made.delta->age = age;
    log.add(made);
  }
  EXPECT_DOUBLE_EQ(row(log.summary(), "wire", "staleness")->spread.median, 2);
}

TEST(FrameLog, HasARowForEveryShareOfAnEye) {
  FrameLog log;
  FrameRecord made = record(1);
  (*made.errors)[1] = {.mask_error = 0.01,
                       .known_error = 0.02,
                       .newest = 0.5,
                       .other_eye = 0.25,
                       .older = 0.125,
                       .cube_mask = 0.015625,
                       .neighbours = 0.0625,
                       .unknown = 0.03125,
                       .stale = 0.4,
                       .unmoved_error = 0.06};
  log.add(made);
  const auto rows = log.summary();
  const std::vector<std::pair<std::string, double>> expected{{"mask error", 1},
                                                             {"mask error among known", 2},
                                                             {"mask error unreprojected", 6},
                                                             {"from newest mask", 50},
                                                             {"from other eye's newest", 25},
                                                             {"from older masks", 12.5},
                                                             {"from the surround", 1.5625},
                                                             {"neighbours", 6.25},
                                                             {"unknown", 3.125},
                                                             {"stale", 40}};
  for (const auto& [metric, percent] : expected) {
    const SummaryRow* const found = row(rows, "right eye", metric);
    ASSERT_NE(found, nullptr) << metric;
    EXPECT_DOUBLE_EQ(found->spread.median, percent) << metric;
    EXPECT_EQ(found->figure->text.unit, "%");
  }
}

TEST(FrameLog, LeavesOutTheErrorsOfAnEyeThatShowsNoSurfaceAndSaysSo) {
  FrameLog log;
  FrameRecord half = record(1), none = record(2);
  (*half.errors)[0] = {.mask_error = 0.01, .unmoved_error = {}, .covered = 0.5};
  (*none.errors)[0] = {.mask_error = 0, .unmoved_error = {}, .covered = 0};
  log.add(half);
  log.add(none);
  const auto rows = log.summary();
  EXPECT_DOUBLE_EQ(row(rows, "left eye", "mask error")->spread.median, 1);
  EXPECT_DOUBLE_EQ(row(rows, "left eye", "shows a surface")->spread.median, 25);
  EXPECT_EQ(row(rows, "left eye", "shows a surface")->spread.count, 2u);
}

TEST(FrameLog, StatesTheCostOfTheCubeMaskOverTheFramesInWhichItsAnswersCame) {
  FrameLog log;
  log.add(record(1));
  FrameRecord made = record(2);
  made.cube_mask = {.rays = 9000, .bytes = 700, .server = Duration(2'000'000)};
  log.add(made);
  const auto rows = log.summary();
  EXPECT_DOUBLE_EQ(row(rows, "server", "rays of the surround")->spread.median, 9000);
  EXPECT_DOUBLE_EQ(row(rows, "server", "frame of the surround")->spread.median, 2);
  EXPECT_DOUBLE_EQ(row(rows, "wire", "bytes of the surround")->spread.median, 700);
  EXPECT_EQ(row(rows, "wire", "bytes of the surround")->spread.count, 1u);
}

TEST(FrameLog, CountsStartUpFramesAndExcludesTheirErrors) {
  FrameLog log;
  for (std::uint32_t frame = 1; frame <= 5; ++frame) {
    FrameRecord made = record(frame);
    if (frame <= 2) {
      made.start_up = true;
      made.delta.reset();
      made.age.reset();
      (*made.errors)[0].mask_error = 1;
    }
    log.add(made);
  }
  EXPECT_EQ(log.start_up_frames(), 2u);
  const auto rows = log.summary();
  EXPECT_EQ(row(rows, "left eye", "mask error")->spread.count, 3u);
  EXPECT_NEAR(row(rows, "left eye", "mask error")->spread.p99, 0.498, 1e-9);
  EXPECT_EQ(row(rows, "wire", "staleness")->spread.count, 3u);
  EXPECT_EQ(row(rows, "wire", "age")->spread.count, 3u);
  EXPECT_EQ(row(rows, "head", "turned since traced view")->spread.count, 3u);
  EXPECT_EQ(row(rows, "client", "frame")->spread.count, 5u) << "their times count";
}

TEST(FrameLog, LeavesOutTheRunTimesOfFramesWithoutTheServerButKeepsTheirErrors) {
  FrameLog log;
  for (std::uint32_t frame = 1; frame <= 3; ++frame) {
    FrameRecord made = record(frame);
    made.silent = frame == 3;
    if (made.silent) made.times.frame = 5s;
    log.add(made);
  }
  const auto rows = log.summary();
  EXPECT_EQ(row(rows, "client", "frame")->spread.count, 2u);
  EXPECT_LT(row(rows, "client", "frame")->spread.p99, 3);
  EXPECT_EQ(row(rows, "wire", "age")->spread.count, 2u);
  EXPECT_EQ(row(rows, "left eye", "mask error")->spread.count, 3u);
}

TEST(FrameLog, HasNoRowWithoutMeasurements) {
  FrameLog log;
  FrameRecord bare = record(1);
  bare.errors.reset();
  log.add(bare);
  const auto rows = log.summary();
  EXPECT_EQ(row(rows, "left eye", "PSNR"), nullptr);
  EXPECT_EQ(row(rows, "server", "frame"), nullptr);
  EXPECT_NE(row(rows, "client", "draw"), nullptr);
  EXPECT_TRUE(FrameLog().summary().empty());
}

TEST(FrameLog, TakesServerFiguresFromReports) {
  FrameLog log;
  FrameRecord made = record(1);
  made.server = FrameReport{.frame = {1},
                            .slices = 9,
                            .payload_bytes = 4000,
                            .primary_rays = 100,
                            .shadow_rays = 50,
                            .full_shadow_rays = 200,
                            .primary = 3ms,
                            .shadow = 4ms,
                            .pack = 2ms,
                            .waited = 1ms};
  log.add(made);
  const auto rows = log.summary();
  EXPECT_DOUBLE_EQ(row(rows, "server", "frame")->spread.median, 9);
  EXPECT_DOUBLE_EQ(row(rows, "server", "share of a full trace")->spread.median, 25);
  EXPECT_DOUBLE_EQ(row(rows, "wire", "datagrams of an answer")->spread.median, 10)
      << "the report is a datagram, too";
  EXPECT_DOUBLE_EQ(row(rows, "wire", "bytes of an answer")->spread.median, 4000);
}

TEST(FrameLog, HasARowForEveryStage) {
  FrameLog log;
  FrameRecord made = record(1);
  made.times = {{.gbuffer = 3ms,
                 .depth = 4ms,
                 .shade = 6ms,
                 .maps = 5ms,
                 .request_reprojection = 15ms,
                 .timewarp = 7ms,
                 .total = 8ms},
                1ms,
                2ms,
                9ms};
  made.server = FrameReport{.primary = 10ms, .shadow = 11ms, .draw = 12ms, .pack = 13ms, .waited = 14ms};
  log.add(made);
  const auto rows = log.summary();
  const std::vector<std::tuple<std::string, std::string, double>> expected{
      {"client", "request", 1},
      {"client", "collect masks", 2},
      {"client", "G-buffer", 3},
      {"client", "depth of requested views", 4},
      {"client", "carry over to requested views", 15},
      {"client", "shadow maps", 5},
      {"client", "reproject and shade", 6},
      {"client", "turn", 7},
      {"client", "draw", 8},
      {"client", "frame", 9},
      {"server", "primary visibility", 10},
      {"server", "draw", 12},
      {"server", "code and pack", 13},
      {"server", "request waited", 14},
      {"server", "frame", 46}};
  for (const auto& [group, metric, ms] : expected) {
    const SummaryRow* const found = row(rows, group, metric);
    ASSERT_NE(found, nullptr) << group << " " << metric;
    EXPECT_DOUBLE_EQ(found->spread.median, ms) << group << " " << metric;
    EXPECT_EQ(found->figure->text.unit, "ms");
  }
}

TEST(FrameLog, HasTheTrafficOfBothDirections) {
  FrameLog log;
  FrameRecord made = record(1);
  made.traffic = LinkTraffic{.up = 93000, .down = 6900};
  log.add(made);
  EXPECT_DOUBLE_EQ(row(log.summary(), "wire", "bytes up a frame")->spread.median, 93000);
  EXPECT_DOUBLE_EQ(row(log.summary(), "wire", "bytes down a frame")->spread.median, 6900);
}

TEST(FrameLog, SaysWhichShareWasAskedFor) {
  FrameLog log;
  FrameRecord made = record(1);
  made.requested = 0.125;
  log.add(made);
  EXPECT_DOUBLE_EQ(row(log.summary(), "wire", "asked for")->spread.median, 12.5);
}

TEST(FrameLog, AHighShareOfTheNewestMaskIsBetter) {
  FrameLog log;
  for (std::uint32_t frame = 1; frame <= 101; ++frame) {
    FrameRecord made = record(frame);
    (*made.errors)[0].newest = (*made.errors)[0].older = 0.001 * frame;
    log.add(made);
  }
  const auto rows = log.summary();
  EXPECT_NEAR(row(rows, "left eye", "from newest mask")->spread.p95, 0.6, 1e-9);
  EXPECT_NEAR(row(rows, "left eye", "from older masks")->spread.p95, 9.6, 1e-9);
}

TEST(SummaryCsv, HasSevenFieldsPerLine) {
  const auto table = cells(summary_csv(full_log().summary()));
  ASSERT_GT(table.size(), 10u);
  EXPECT_EQ(table[0],
            (std::vector<std::string>{"group", "metric", "unit", "median", "p95", "p99", "frames"}));
  for (const auto& line : table) EXPECT_EQ(line.size(), 7u);
  EXPECT_EQ(table[1], (std::vector<std::string>{"client", "frame", "ms", "51", "96", "100", "101"}));
}

TEST(FramesCsv, HasOneRowPerFrameAndEmptyFieldsWithoutMeasurements) {
  FrameRecord unmeasured = record(8);
  unmeasured.errors.reset();
  const auto table = cells(frames_csv({record(7), unmeasured}));
  ASSERT_EQ(table.size(), 3u);
  for (const auto& line : table) EXPECT_EQ(line.size(), table[0].size());
  const auto column = [&](const std::string& name) {
    const auto found = std::ranges::find(table[0], name);
    EXPECT_NE(found, table[0].end()) << name;
    return static_cast<std::size_t>(found - table[0].begin());
  };
  EXPECT_EQ(table[1][0], "7");
  EXPECT_EQ(table[1][1], "70000000");
  EXPECT_EQ(table[1][column("server_silent")], "0");
  EXPECT_EQ(table[1][column("left eye mask error [%]")], "0.7");
  EXPECT_EQ(table[2][column("left eye mask error [%]")], "");
  EXPECT_EQ(table[2][column("client frame [ms]")], "8");
  EXPECT_EQ(table[1][column("wire datagrams of an answer [datagrams]")], "");
}

}  // namespace
}  // namespace farshade
