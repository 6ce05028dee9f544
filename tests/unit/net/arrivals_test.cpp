#include "stereo/net/arrivals.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "stereo/net/arrival_clock.h"

namespace farshade {
namespace {

using std::chrono::milliseconds;

Time at(std::int64_t ms) {
  return time_from_ns(ms * 1'000'000);
}

TEST(Arrivals, WithoutArrivalsTheReportIsEmpty) {
  Arrivals arrivals;
  EXPECT_EQ(arrivals.report().count, 0U);
  EXPECT_EQ(arrivals.missing(), 0U);
}

TEST(Arrivals, EachArrivalIsInAFixedNumberOfReports) {
  Arrivals arrivals;
  arrivals.add(7, at(3));
  arrivals.add(9, at(5));
  for (std::size_t i = 0; i < Arrivals::kReports; ++i) {
    const ArrivalReport report = arrivals.report();
    ASSERT_EQ(report.count, 3U);
    EXPECT_EQ(report.first, 7U);
    EXPECT_EQ(report.base, at(3));
    EXPECT_TRUE(report.arrived(0));
    EXPECT_FALSE(report.arrived(1));
    EXPECT_EQ(report.arrival(2), at(3) + 31 * ArrivalReport::kTick);
  }
  EXPECT_EQ(arrivals.report().count, 0U);
  EXPECT_EQ(arrivals.received(), 2U);
  EXPECT_EQ(arrivals.missing(), 1U);
}

TEST(Arrivals, ALateArrivalExtendsTheReportBackToIt) {
  Arrivals arrivals;
  for (std::uint64_t counter = 10; counter < 20; ++counter)
    if (counter != 12) arrivals.add(counter, at(30));
  for (std::size_t i = 0; i < Arrivals::kReports; ++i) static_cast<void>(arrivals.report());
  arrivals.add(12, at(90));
  const ArrivalReport report = arrivals.report();
  EXPECT_EQ(report.first, 12U);
  EXPECT_EQ(report.base, at(30));
  EXPECT_EQ(report.count, 8U);
  EXPECT_EQ(report.arrival(0), at(30) + 937 * ArrivalReport::kTick);
}

TEST(Arrivals, SkippedDatagramsAfterAPauseAreReportedAbsent) {
  Arrivals arrivals;
  arrivals.add(10, at(0));
  for (std::size_t i = 0; i < Arrivals::kReports; ++i) static_cast<void>(arrivals.report());
  arrivals.add(14, at(500));
  const ArrivalReport report = arrivals.report();
  EXPECT_EQ(report.first, 11U);
  EXPECT_EQ(report.count, 4U);
  EXPECT_FALSE(report.arrived(0) || report.arrived(1) || report.arrived(2));
  EXPECT_TRUE(report.arrived(3));
}

TEST(Arrivals, KeepsTheNewestCountersAndForgetsThoseBeforeAGap) {
  Arrivals arrivals;
  for (std::uint64_t counter = 0; counter < 1000; ++counter) arrivals.add(counter, at(1));
  EXPECT_EQ(arrivals.report().first, 1000 - ArrivalReport::kMost);
  arrivals.add(100'000, at(2));
  arrivals.add(5, at(3));  // too old for the report, but counted
  const ArrivalReport report = arrivals.report();
  EXPECT_EQ(report.count, ArrivalReport::kMost);
  EXPECT_EQ(report.first + report.count - 1, 100'000U);
  for (std::size_t i = 0; i + 1 < report.count; ++i) EXPECT_FALSE(report.arrived(i));
  EXPECT_TRUE(report.arrived(report.count - 1));
  EXPECT_EQ(arrivals.received(), 1002U);
}

TEST(Arrivals, ArrivalsTooOldForTheTicksAreLeftOut) {
  Arrivals arrivals;
  arrivals.add(1, at(0));
  arrivals.add(2, at(10'000));
  arrivals.add(3, at(10'001));
  const ArrivalReport report = arrivals.report();
  EXPECT_EQ(report.first, 2U);
  EXPECT_EQ(report.count, 2U);
  EXPECT_EQ(report.base, at(10'000));
}

TEST(Arrivals, RandomOrdersAreReportedAsTheyArrived) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    Arrivals arrivals;
    std::map<std::uint64_t, Time> came, told;
    for (std::int64_t ms = 0; ms < 3000; ++ms) {
      const std::uint64_t counter = static_cast<std::uint64_t>(ms) + 50 - random() % 50;
      if (came.emplace(counter, at(ms)).second) arrivals.add(counter, at(ms));
      if (ms % 14 != 0) continue;
      const ArrivalReport report = arrivals.report();
      if (random() % 4 == 0) continue;
      for (std::uint32_t i = 0; i < report.count; ++i)
        if (report.arrived(i)) told.emplace(report.first + i, report.arrival(i));
    }
    for (const auto& [counter, time] : told) {
      ASSERT_TRUE(came.contains(counter));
      EXPECT_LT(std::chrono::abs(came[counter] - time), ArrivalReport::kTick);
    }
    EXPECT_GT(static_cast<double>(told.size()), 0.98 * static_cast<double>(came.size()));
  }
}

constexpr Duration kWall = std::chrono::hours(500'000);  // since 1970

TEST(ArrivalClock, TakesTheTimeInTheSocketOffTheTimeOfReading) {
  ArrivalClock clock;
  clock.read(kWall, at(0));
  clock.read(kWall + milliseconds(100), at(100));
  EXPECT_EQ(clock.arrival(kWall + milliseconds(70)), at(70));
  EXPECT_EQ(clock.arrival(kWall + milliseconds(130)), at(100)) << "not in the future";
  // A minute later the wall clock has been slowed down by 500 ppm.
  clock.read(kWall + milliseconds(60'100 - 30), at(60'100));
  EXPECT_EQ(clock.arrival(kWall + milliseconds(60'050 - 30)), at(60'050));
}

TEST(ArrivalClock, AStepOfTheWallClockMakesNoDatagramOld) {
  for (const Duration step : {Duration(std::chrono::hours(1)), Duration(std::chrono::hours(-1))}) {
    ArrivalClock clock;
    clock.read(kWall, at(0));
    // Two datagrams wait with stamps of 90 and 95 ms. The clock is set, and then both are read.
    const auto wall = [&](int ms) { return kWall + step + milliseconds(ms); };
    clock.read(wall(100), at(100));
    EXPECT_EQ(clock.arrival(kWall + milliseconds(90)), at(100));
    clock.read(wall(101), at(101));
    const Time second = clock.arrival(kWall + milliseconds(95));
    EXPECT_GE(second, at(100));
    EXPECT_LE(second, at(101));
    // What comes from then on has its own time again.
    clock.read(wall(200), at(200));
    EXPECT_EQ(clock.arrival(wall(180)), at(180));
  }
}

}  // namespace
}  // namespace farshade
