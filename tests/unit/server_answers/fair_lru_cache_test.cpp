// What a client that cycles through sizes or bit rates costs the clients of other keys.
#include "rt_server/answers/fair_lru_cache.h"

#include <gtest/gtest.h>

#include "rt_server/answers/rebuilds.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr KeyId kGood{1}, kOther{2}, kEvil{9};

TEST(FairLruCache, AKeyThatCyclesSizesLosesItsOwnValuesOnly) {
  FairLruCache<int, int> kept(4, 1000);
  kept.put(1, kGood, 1, 10);
  kept.put(2, kOther, 1, 20);
  for (int size = 100; size < 200; ++size) kept.put(size, kEvil, 1, size);
  EXPECT_NE(kept.find(1), nullptr);
  EXPECT_NE(kept.find(2), nullptr);
  EXPECT_NE(kept.find(199), nullptr);
  EXPECT_EQ(kept.find(197), nullptr);
}

TEST(FairLruCache, ANewKeyTakesFromTheOneWithTheMost) {
  FairLruCache<int, int> kept(4, 1000);
  kept.put(1, kGood, 1, 10);
  for (int size = 100; size < 103; ++size) kept.put(size, kEvil, 1, size);
  kept.put(2, kOther, 1, 20);
  EXPECT_NE(kept.find(1), nullptr);
  EXPECT_EQ(kept.find(100), nullptr) << "its least recently used";
  EXPECT_NE(kept.find(101), nullptr);
}

TEST(FairLruCache, AmongEqualsTheLeastRecentlyUsedGoes) {
  FairLruCache<int, int> kept(2, 1000);
  kept.put(1, kGood, 1, 10);
  kept.put(2, kEvil, 1, 20);
  EXPECT_NE(kept.find(1), nullptr);
  kept.put(3, kOther, 1, 30);
  EXPECT_EQ(kept.find(2), nullptr);
  EXPECT_NE(kept.find(1), nullptr);
}

TEST(FairLruCache, HoldsNoMoreBytesThanItMay) {
  FairLruCache<int, int> kept(4, 100);
  kept.put(1, kGood, 60, 10);
  kept.put(2, kGood, 60, 20);
  EXPECT_EQ(kept.find(1), nullptr);
  kept.put(3, kGood, 40, 30);
  EXPECT_NE(kept.find(2), nullptr);
  kept.put(4, kGood, 500, 40);
  EXPECT_EQ(kept.find(2), nullptr);
  EXPECT_EQ(kept.find(3), nullptr);
  EXPECT_NE(kept.find(4), nullptr) << "one alone is always kept";
}

TEST(Rebuilds, AreLimitedByKey) {
  Rebuilds rebuilds;
  const auto made = [&](const KeyId& key, Time now) {
    int count = 0;
    try {
      for (; count < 100; ++count) rebuilds.take(key, now);
    } catch (const RebuiltTooOften&) {
    }
    return count;
  };
  EXPECT_EQ(made(kEvil, Time(10s)), 16);
  EXPECT_EQ(made(kGood, Time(10s)), 16) << "another key has its own";
  EXPECT_EQ(made(kEvil, Time(10s + 500ms)), 8);
  EXPECT_EQ(made(kEvil, Time(1min)), 16);
}

}  // namespace
}  // namespace farshade
