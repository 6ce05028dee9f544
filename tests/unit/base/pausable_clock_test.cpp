#include "stereo/base/pausable_clock.h"

#include <gtest/gtest.h>

#include "tests/support/manual_clock.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

TEST(PausableClock, LeavesOutItsStops) {
  ManualClock base;
  base.advance_to(Time(1s));
  PausableClock clock(base);
  EXPECT_EQ(clock.now(), Time(1s));
  clock.stop();
  base.advance_to(Time(5s));
  clock.stop();
  EXPECT_EQ(clock.now(), Time(1s)) << "a second stop is none";
  clock.resume();
  base.advance_to(Time(6s));
  clock.resume();
  EXPECT_EQ(clock.now(), Time(2s));
  clock.stop();
  base.advance_to(Time(16s));
  clock.resume();
  base.advance_to(Time(17s));
  EXPECT_EQ(clock.now(), Time(3s));
}

TEST(PausableClock, ConvertsTimesAroundItsLastStop) {
  ManualClock base;
  PausableClock clock(base);
  base.advance_to(Time(1s));
  clock.stop();
  base.advance_to(Time(3s));
  clock.resume();
  base.advance_to(Time(4s));
  clock.stop();
  EXPECT_EQ(clock.at(Time(3500ms)), Time(1500ms));
  EXPECT_EQ(clock.at(Time(9s)), Time(2s)) << "stopped";
  base.advance_to(Time(6s));
  clock.resume();
  EXPECT_EQ(clock.at(Time(3s)), Time(1s));
  EXPECT_EQ(clock.at(Time(4s)), Time(2s));
  EXPECT_EQ(clock.at(Time(5s)), Time(2s)) << "during the stop";
  EXPECT_EQ(clock.at(Time(7s)), Time(3s));
}

}  // namespace
}  // namespace farshade
