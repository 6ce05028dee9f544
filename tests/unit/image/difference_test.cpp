#include "stereo/image/difference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace farshade {
namespace {

Image<Rgb8> filled(Extent size, Rgb8 colour) {
  return Image<Rgb8>(size, colour);
}

TEST(Mse, IsMeanOverPixelsAndChannels) {
  const auto a = filled({2, 1}, {10, 20, 30});
  auto b = a;
  EXPECT_EQ(mse(a, b), 0);
  b.at(1, 0) = {13, 20, 26};
  EXPECT_DOUBLE_EQ(mse(a, b), (9.0 + 0.0 + 16.0) / 6.0);
  EXPECT_EQ(mse(a, b), mse(b, a));
}

TEST(Mse, HoldsLargestDifferences) {
  EXPECT_DOUBLE_EQ(mse(filled({1000, 1000}, Rgb8(0)), filled({1000, 1000}, Rgb8(255))), 65025.0);
}

TEST(MseDeathTest, RefusesUnequalSizes) {
  EXPECT_DEATH((void)mse(filled({2, 1}, Rgb8(0)), filled({1, 2}, Rgb8(0))), "one size");
}

TEST(Psnr, MatchesPaperAnswers) {
  const auto black = filled({4, 4}, Rgb8(0));
  EXPECT_EQ(psnr_db(black, black), std::numeric_limits<double>::infinity());
  EXPECT_DOUBLE_EQ(psnr_db(black, filled({4, 4}, Rgb8(255))), 0.0);
  EXPECT_NEAR(psnr_db(black, filled({4, 4}, Rgb8(1))), 48.1308, 1e-4);  // 20 log10(255)
  auto one_channel = black;
  one_channel.at(2, 3).g = 255;
  EXPECT_NEAR(psnr_db(black, one_channel), 10 * std::log10(48.0), 1e-12);
}

TEST(DifferenceX8, IsAbsoluteAndCutOff) {
  const auto shown = difference_x8(filled({3, 2}, {10, 20, 0}), filled({3, 2}, {13, 19, 32}));
  EXPECT_EQ(shown, filled({3, 2}, {24, 8, 255}));
  EXPECT_EQ(difference_x8(filled({1, 1}, Rgb8(31)), filled({1, 1}, Rgb8(0))).at(0, 0), Rgb8(248));
}

}  // namespace
}  // namespace farshade
