#include "stereo/base/stages.h"

#include <gtest/gtest.h>

#include "tests/support/manual_clock.h"

namespace farshade {
namespace {

TEST(Stages, AreAsLongAsTheTimeSinceTheLastOne) {
  ManualClock clock;
  clock.advance_to(time_from_ns(5'000'000));
  Stages stages(clock);
  clock.advance_to(time_from_ns(305'000'000));
  stages.end("scene");
  clock.advance_to(time_from_ns(305'100'000));
  stages.end("server");
  clock.advance_to(time_from_ns(317'100'000));
  stages.end("first frame");
  clock.advance_to(time_from_ns(900'000'000));
  EXPECT_DOUBLE_EQ(ms_of(stages.total()), 312.1);
  EXPECT_EQ(stages.in_words(), "312 ms: scene 300, first frame 12");
}

TEST(Stages, ThatEndAgainGetLonger) {
  ManualClock clock;
  Stages stages(clock);
  for (const std::int64_t ms : {10, 30, 60}) {
    clock.advance_to(time_from_ns(ms * 1'000'000));
    stages.end(ms == 30 ? "device" : "head");
  }
  EXPECT_EQ(stages.in_words(), "60 ms: head 40, device 20");
}

TEST(Stages, AreNoneBeforeTheFirstEnds) {
  ManualClock clock;
  EXPECT_EQ(Stages(clock).in_words(), "0 ms");
}

}  // namespace
}  // namespace farshade
