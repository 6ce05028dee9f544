// Turns: who is next, and what is held for whom.
#include "rt_server/core/turns.h"

#include <gtest/gtest.h>

#include "vr_client/ask/guard_band.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr JobSize kJob{.pixels = 1000};
const KeyId kA{1}, kB{2}, kC{3};

/// A job of `key` that ends at `now` after `work`.
void serve(Turns& turns, const KeyId& key, Duration work, Time now) {
  turns.begin(key);
  turns.costs(key).took(kJob, work);
  turns.end(key, work, now);
}

TEST(Turns, UsualViewsAreThoseThatAClientAsksForWithItsWidestGuardBand) {
  EXPECT_EQ(largest_traced({512, 512}).pixels(), kUsualPixels);
}

TEST(Turns, AShareOfRestFollowsALongJob) {
  Turns turns;
  turns.was_active(kB, Time(1s));
  serve(turns, kA, 100ms, Time(1s));
  EXPECT_EQ(turns.held_until(kA, kJob), Time(1100ms));
  turns.was_active(kC, Time(2s));
  turns.was_active(kB, Time(2s));
  serve(turns, kA, 100ms, Time(2s));
  EXPECT_EQ(turns.held_until(kA, kJob), Time(2050ms)) << "a share of two";
}

TEST(Turns, NothingIsHeldForAKeyThatIsBehind) {
  Turns turns;
  turns.was_active(kB, Time(1s));
  serve(turns, kA, 100ms, Time(1s));
  serve(turns, kB, 200ms, Time(1200ms));
  EXPECT_FALSE(turns.held_until(kA, kJob));
  EXPECT_EQ(turns.held_until(kB, kJob), Time(1s) + Turns::kActive);
}

TEST(Turns, NothingIsHeldForAKeyThatNoLongerAsks) {
  Turns turns;
  serve(turns, kB, 1ms, Time(1s));
  serve(turns, kA, 2s, Time(3s));
  EXPECT_LE(turns.held_until(kA, kJob).value_or(Time{}), Time(3s)) << "it asked 2 s ago";
  turns.was_active(kB, Time(3s));
  serve(turns, kA, 2s, Time(3s));
  EXPECT_EQ(turns.held_until(kA, kJob), Time(3s) + Turns::kActive) << "and not for the whole rest";
}

TEST(Turns, ShortJobsAreNeitherHeldNorBeginARest) {
  Turns turns;
  turns.was_active(kB, Time(1s));
  serve(turns, kA, 100ms, Time(1s));
  EXPECT_FALSE(turns.held_until(kC, kJob)) << "nobody knows what it costs";
  constexpr JobSize kShort{.pixels = 200};
  EXPECT_FALSE(turns.held_until(kA, kShort)) << "20 ms";
  serve(turns, kC, Turns::kShortJob, Time(1010ms));
  EXPECT_EQ(turns.held_until(kA, kJob), Time(1100ms)) << "the rest is that of the long job";
}

TEST(Turns, AKeyThatWasAwayIsAheadByTheLastLongJobAndNoMore) {
  Turns turns;
  for (int i = 0; i < 30; ++i) serve(turns, kA, 10ms, {});
  EXPECT_EQ(turns.order(kB).first, 290ms - Turns::kBank);
  serve(turns, kA, 1s, {});
  serve(turns, kA, 10ms, {});
  EXPECT_EQ(turns.order(kB).first, 1300ms - 1s);
  EXPECT_EQ(turns.order(kA).first, 1310ms);
  turns.keep({});
  EXPECT_EQ(turns.order(kA).first, 300ms) << "its account has ended";
}

}  // namespace
}  // namespace farshade
