#include "stereo/sealing/replay_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace farshade {
namespace {

/// The definition of the window in its simplest form: it remembers all accepted counters.
struct NaiveWindow {
  std::set<std::uint64_t> taken;

  [[nodiscard]] bool is_new(std::uint64_t counter) const {
    if (taken.empty()) return true;
    const std::uint64_t newest = *taken.rbegin();
    return counter > newest || (newest - counter < ReplayWindow::kSize && !taken.contains(counter));
  }
};

TEST(ReplayWindow, TakesAnyCounterFirst) {
  for (const std::uint64_t first : {std::uint64_t{0}, std::uint64_t{5000}, ~std::uint64_t{0}}) {
    ReplayWindow window;
    EXPECT_EQ(window.newest(), std::nullopt);
    EXPECT_TRUE(window.is_new(first));
    window.take(first);
    EXPECT_FALSE(window.is_new(first));
    EXPECT_EQ(window.newest(), first);
  }
}

TEST(ReplayWindow, ReachesBack4095AndNoFurther) {
  static_assert(ReplayWindow::kSize >= 4096);
  for (std::uint64_t newest = 10'000; newest < 10'130; ++newest) {  // all places within a word
    ReplayWindow window;
    window.take(newest);
    EXPECT_TRUE(window.is_new(newest - 4095));
    EXPECT_FALSE(window.is_new(newest - 4096));
    EXPECT_FALSE(window.is_new(newest - 4097));
    window.take(newest - 4095);
    EXPECT_FALSE(window.is_new(newest - 4095));
    EXPECT_TRUE(window.is_new(newest - 4094));
    EXPECT_EQ(window.newest(), newest);
  }
}

TEST(ReplayWindow, RemembersItsOldestUntilItLeaves) {
  ReplayWindow window;
  window.take(100);
  window.take(100 + 4095);
  EXPECT_FALSE(window.is_new(100));
  EXPECT_TRUE(window.is_new(101));
  window.take(100 + 4096);
  EXPECT_FALSE(window.is_new(100));
  EXPECT_TRUE(window.is_new(101));
}

TEST(ReplayWindow, QueriesChangeNothing) {
  ReplayWindow window;
  window.take(7);
  EXPECT_TRUE(window.is_new(1'000'000));
  EXPECT_EQ(window.newest(), 7u);
  EXPECT_TRUE(window.is_new(6));
  EXPECT_FALSE(window.is_new(7));
}

TEST(ReplayWindow, AgreesWithASetOfAllThatWasTaken) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto up_to = [&](std::uint64_t most) {
    return std::uniform_int_distribution<std::uint64_t>(0, most)(random);
  };
  for (int run = 0; run < 20; ++run) {
    ReplayWindow window;
    NaiveWindow naive;
    std::uint64_t newest = up_to(1) == 0 ? up_to(100) : up_to(~std::uint64_t{0} / 2);
    for (int i = 0; i < 5000; ++i) {
      std::uint64_t counter = newest;
      switch (up_to(5)) {
        case 0:
          counter += 1;
          break;
        case 1:
          counter += up_to(70);
          break;
        case 2:
          counter += up_to(100) == 0 ? up_to(20'000) : 1;
          break;  // sometimes beyond the ring
        case 3:
          counter -= std::min(counter, up_to(80));
          break;
        case 4:
          counter -= std::min(counter, up_to(4300));
          break;
        default:
          counter -= std::min(counter, 4090 + up_to(10));
          break;
      }
      ASSERT_EQ(window.is_new(counter), naive.is_new(counter)) << counter << " after " << newest;
      if (!naive.is_new(counter)) continue;
      window.take(counter);
      naive.taken.insert(counter);
      newest = *naive.taken.rbegin();
      ASSERT_EQ(window.newest(), newest);
    }
  }
}

TEST(ReplayWindow, CountersBeyondWhatASenderCanReachAreTooFar) {
  ReplayWindow window;
  EXPECT_FALSE(window.is_too_far(ReplayWindow::kMostJump));
  EXPECT_TRUE(window.is_too_far(ReplayWindow::kMostJump + 1));
  window.take(1000);
  EXPECT_FALSE(window.is_too_far(0)) << "an old counter is old, not far";
  EXPECT_FALSE(window.is_too_far(1000 + ReplayWindow::kMostJump));
  EXPECT_TRUE(window.is_too_far(1001 + ReplayWindow::kMostJump));
  EXPECT_TRUE(window.is_too_far(~std::uint64_t{0}));
  window.take(ReplayWindow::kMostCounter);
  EXPECT_TRUE(window.is_too_far(ReplayWindow::kMostCounter + 1));
}

}  // namespace
}  // namespace farshade
