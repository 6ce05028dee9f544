// Turns: who is next, and what is held for whom.
#include "rt_server/scheduling/turns.h"

#include <gtest/gtest.h>

#include "stereo/requests/guard_band.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

const KeyId kA{1}, kB{2}, kC{3};

void serve(Turns& turns, const KeyId& key, Duration work, Time ends) {
  turns.begin(key);
  turns.end(key, work, ends);
}

TEST(Turns, UsualViewsAreThoseThatAClientAsksForWithItsWidestGuardBand) {
  EXPECT_EQ(largest_traced({512, 512}).pixels(), kUsualPixels);
}

TEST(Turns, AKeyThatIsAheadIsWaitedForAsLongAsItIsAhead) {
  Turns turns;
  turns.was_active(kB, Time(1s));
  serve(turns, kA, 100ms, Time(1s));
  EXPECT_FALSE(turns.look_at(kA)) << "the worker does not wait";
  EXPECT_TRUE(turns.is_held(kA, Time(1s)));
  EXPECT_FALSE(turns.is_held(kB, Time(1s)));
  turns.wait_for_others(kA, Time(1s));
  EXPECT_EQ(turns.look_at(kA), Time(1100ms));
  EXPECT_FALSE(turns.look_at(kB)) << "a job of this key begins at once";
  turns.look(Time(1040ms));
  EXPECT_EQ(turns.order(kB).first, 40ms) << "the time that it did not use is its own";
  serve(turns, kB, 20ms, Time(1060ms));
  ASSERT_TRUE(turns.is_held(kA, Time(1060ms)));
  turns.wait_for_others(kA, Time(1060ms));
  EXPECT_EQ(turns.look_at(kA), Time(1100ms));
  turns.look(Time(1107ms));
  EXPECT_EQ(turns.order(kB).first, 100ms) << "no more than it was waited for";
  EXPECT_FALSE(turns.is_held(kA, Time(1107ms)));
}

TEST(Turns, TheWorkerLooksAgainForTheKeyThatIsHeldLeast) {
  Turns turns;
  turns.was_active(kC, Time(1s));
  serve(turns, kA, 100ms, Time(1s));
  serve(turns, kB, 50ms, Time(1s));
  turns.wait_for_others(kB, Time(1s));
  EXPECT_EQ(turns.look_at(kA), Time(1050ms));
  EXPECT_EQ(turns.look_at(kB), Time(1050ms));
  EXPECT_FALSE(turns.look_at(kC));
  turns.look(Time(1050ms));
  EXPECT_FALSE(turns.is_held(kB, Time(1050ms)));
  EXPECT_TRUE(turns.is_held(kA, Time(1050ms)));
}

TEST(Turns, AKeyThatNoLongerAsksIsNotWaitedFor) {
  Turns turns;
  serve(turns, kB, 1ms, Time(1s));
  serve(turns, kA, 1s, Time(1s));
  const Time end = Time(1s) + Turns::kActive;
  EXPECT_TRUE(turns.is_held(kA, end - 1ns));
  turns.wait_for_others(kA, end - 1ms);
  EXPECT_EQ(turns.look_at(kA), end);
  EXPECT_FALSE(turns.is_held(kA, end));
}

TEST(Turns, AKeyWhoseJobsAreShortIsNotHeld) {
  Turns turns;
  turns.was_active(kB, Time(1s));
  for (int i = 0; i < 100; ++i) serve(turns, kA, Turns::kShortJob, Time(1s));
  EXPECT_FALSE(turns.is_held(kA, Time(1s)));
  serve(turns, kA, Turns::kShortJob + 1ns, Time(1s));
  EXPECT_TRUE(turns.is_held(kA, Time(1s)));
  serve(turns, kA, 1ms, Time(2s));
  const Time short_again = Time(1s) + Turns::kLong;
  turns.was_active(kB, short_again);
  EXPECT_TRUE(turns.is_held(kA, short_again - 1ns)) << "a short job in between does not help it";
  turns.wait_for_others(kA, short_again - 1ms);
  EXPECT_EQ(turns.look_at(kA), short_again);
  EXPECT_FALSE(turns.is_held(kA, short_again));
}

TEST(Turns, AKeyThatWasAwayIsAheadByItsBankAndNoMore) {
  Turns turns;
  for (int i = 0; i < 30; ++i) serve(turns, kA, 10ms, {});
  EXPECT_EQ(turns.order(kB).first, 290ms - Turns::kBank);
  EXPECT_EQ(turns.order(kA).first, 300ms);
  turns.keep({});
  EXPECT_EQ(turns.order(kA).first, 290ms - Turns::kBank) << "its account has ended";
}

}  // namespace
}  // namespace farshade
