#include "stereo/requests/steady_band.h"

#include <gtest/gtest.h>

#include <random>

namespace farshade {
namespace {

using SteadyMargins = Sides<std::uint32_t>;

constexpr Extent kSteadySize{256, 192};
constexpr Extent kSteadyMost{64, 48};  ///< largest_traced(kSteadySize) minus kSteadySize
constexpr int kTwoSeconds = 144;

Extent growth_of(const SteadyMargins& margins) {
  return {margins.left + margins.right, margins.up + margins.down};
}

TEST(SteadyBand, IsZeroIfNothingIsNeeded) {
  SteadyBand band;
  for (int i = 0; i < 3 * kTwoSeconds; ++i) EXPECT_EQ(band.margins_px({}, kSteadySize), SteadyMargins{});
}

TEST(SteadyBand, AnAxisHasThreeWidths) {
  const auto across = [](std::uint32_t left, std::uint32_t right) {
    return growth_of(SteadyBand().margins_px({.left = left, .right = right}, kSteadySize)).width;
  };
  EXPECT_EQ(across(16, 0), 32u);
  EXPECT_EQ(across(16, 16), 32u);
  EXPECT_EQ(across(32, 16), 64u);
  EXPECT_EQ(across(0, 64), 64u);
  EXPECT_EQ(growth_of(SteadyBand().margins_px({.up = 16}, kSteadySize)), (Extent{0, 24}));
  EXPECT_EQ(growth_of(SteadyBand().margins_px({.up = 16, .down = 16}, kSteadySize)), (Extent{0, 48}));
}

TEST(SteadyBand, DividesTheGrowthAsTheSidesNeedIt) {
  EXPECT_EQ(SteadyBand().margins_px({.left = 16, .right = 48, .down = 16}, kSteadySize),
            (SteadyMargins{.left = 16, .right = 48, .up = 0, .down = 24}));
  EXPECT_EQ(SteadyBand().margins_px({.left = 16, .right = 32}, kSteadySize).left, 21u);
}

/// Each change of size costs a key frame.
TEST(SteadyBand, GrowsAtOnceAndShrinksAfterTwoSeconds) {
  SteadyBand band;
  band.margins_px({.left = 16}, kSteadySize);
  const SteadyMargins wide = band.margins_px({.left = 48}, kSteadySize);
  EXPECT_EQ(wide.left, 64u);
  for (int i = 1; i < kTwoSeconds; ++i) ASSERT_EQ(band.margins_px({.left = 16}, kSteadySize), wide) << i;
  EXPECT_EQ(band.margins_px({.left = 16}, kSteadySize).left, 32u);
}

TEST(SteadyBand, CoversWhatIsNeededWithinTheLargestSize) {
  std::mt19937 random(11);  // the seed
  SteadyBand band;
  SteadyMargins held;
  for (int i = 0; i < kTwoSeconds; ++i) {
    const auto margin = [&](std::uint32_t most) {
      return 16 * static_cast<std::uint32_t>(random() % (most / 16 + 1));
    };
    const SteadyMargins needed{margin(32), margin(32), margin(16), margin(32)};
    held = {std::max(held.left, needed.left), std::max(held.right, needed.right),
            std::max(held.up, needed.up), std::max(held.down, needed.down)};
    const SteadyMargins got = band.margins_px(needed, kSteadySize);
    ASSERT_GE(got.left, held.left);
    ASSERT_GE(got.right, held.right);
    ASSERT_GE(got.up, held.up);
    ASSERT_GE(got.down, held.down);
    ASSERT_LE(growth_of(got).width, kSteadyMost.width);
    ASSERT_LE(growth_of(got).height, kSteadyMost.height);
  }
}

/// Needs of different moments may be more than there is room for.
TEST(SteadyBand, NeverExceedsTheLargestSize) {
  SteadyBand band;
  band.margins_px({.left = 64, .up = 48}, kSteadySize);
  EXPECT_EQ(band.margins_px({.right = 64, .down = 48}, kSteadySize),
            (SteadyMargins{.left = 32, .right = 32, .up = 24, .down = 24}));
}

}  // namespace
}  // namespace farshade
