#include "stereo/base/clock.h"

#include <gtest/gtest.h>

#include "tests/support/manual_clock.h"

namespace farshade {
namespace {

TEST(Time, GoesThroughNanosecondsUnchanged) {
  for (const std::int64_t ns : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{1} << 62})
    EXPECT_EQ(ns_of(time_from_ns(ns)), ns);
}

TEST(Duration, ConvertsToAndFromMilliseconds) {
  EXPECT_EQ(duration_from_ms(1.5).count(), 1'500'000);
  EXPECT_DOUBLE_EQ(ms_of(Duration(2'500'000)), 2.5);
  EXPECT_DOUBLE_EQ(seconds_of(Duration(2'500'000)), 0.0025);
}

TEST(ManualClock, NeverGoesBack) {
  ManualClock clock;
  clock.advance_to(time_from_ns(10));
  clock.advance_to(time_from_ns(5));
  EXPECT_EQ(ns_of(clock.now()), 10);
}

TEST(SteadyClock, NeverGoesBack) {
  const SteadyClock clock;
  const Time first = clock.now();
  EXPECT_GE(clock.now(), first);
}

}  // namespace
}  // namespace farshade
