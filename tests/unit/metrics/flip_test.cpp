#include "stereo/metrics/flip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

namespace farshade {
namespace {

constexpr Rgb8 kBlack{0, 0, 0}, kWhite{255, 255, 255}, kRed{255, 0, 0}, kGreen{0, 255, 0}, kBlue{0, 0, 255};
constexpr double kMonitor = 67;  // the paper's monitor: 0.7 m wide, 3840 pixels, seen from 0.7 m

/// So few pixels per degree that every Gaussian is within one pixel: nothing is blurred, the edge detector is
/// p[1] - p[-1], the point detector (p[-1] + p[1]) / 2 - p[0].
constexpr double kCoarse = 0.01;

/// The error between two pictures of one colour each. It is the same everywhere.
double between(Rgb8 reference, Rgb8 test, double pixels_per_degree = kMonitor) {
  const Image<float> error =
      flip(Image<Rgb8>({9, 7}, reference), Image<Rgb8>({9, 7}, test), pixels_per_degree);
  for (const float e : error.pixels) EXPECT_NEAR(e, error.pixels[0], 1e-6);
  return error.pixels[0];
}

/// Blurring and feature detection do not change a constant picture, so the error is the mapped colour
/// difference.
///
/// The scale: XYZ relative to white are the columns of the sRGB matrix over D65,
///   green (0.37622, 0.71517, 0.10945): cube roots 0.72190, 0.89427, 0.47834
///     L = 116 * 0.89427 - 16 = 87.7355, a = 500 (0.72190 - 0.89427) = -86.18, b = 200 (0.89427 - 0.47834)
///     = 83.19 Hunt: 0.877355 (a, b) = (-75.61, 72.98)
///   blue (0.18989, 0.07219, 0.87280): cube roots 0.57477, 0.41639, 0.95567
///     L = 32.3009, a = 79.20, b = -107.86, Hunt: (25.58, -34.84)
///   HyAB = 55.435 + |(101.19, 107.82)| = 55.435 + 147.870 = 203.305, largest = 203.305^0.7 = 41.2766,
///   the knee at 0.4 of it: 16.5106.
TEST(FlipOfConstants, MatchesPaperAnswers) {
  // L 0 and 100: 100^0.7 = 25.1189, beyond the knee: 0.95 + 0.05 (25.1189 - 16.5106) / (41.2766 - 16.5106).
  EXPECT_NEAR(between(kBlack, kWhite), 0.967379, 2e-6);
  // The largest possible difference.
  EXPECT_NEAR(between(kGreen, kBlue), 1.0, 1e-6);
  EXPECT_LE(between(kGreen, kBlue), 1.0);
  // Red: XYZ (0.43389, 0.21264, 0.01775): L 53.2371, Hunt (42.638, 35.777); HyAB to green 34.498 +
  // |(118.250, 37.207)| = 158.463; ^0.7 = 34.6696; 0.95 + 0.05 (34.6696 - 16.5106) / 24.7660.
  EXPECT_NEAR(between(kRed, kGreen), 0.986661, 2e-6);
  // Grey 10: 10 / 255 / 12.92 = 0.00303527 < (6/29)^3, L = 24389/27 of it = 2.741748; ^0.7 = 2.025899;
  // below the knee: 0.95 / 16.5106 of it.
  EXPECT_NEAR(between(kBlack, {10, 10, 10}), 0.116568, 2e-6);
  // Grey 64: ((64/255 + 0.055) / 1.055)^2.4 = 0.0512695, L = 116 * 0.371495 - 16 = 27.09341; ^0.7 = 10.06939.
  EXPECT_NEAR(between(kBlack, {64, 64, 64}), 0.579381, 2e-6);
}

TEST(FlipOfConstants, DoesNotDependOnPixelsPerDegree) {
  for (const double ppd : {1e-6, 0.01, 1.0, 8.9, 67.0, 1000.0})
    EXPECT_NEAR(between(kRed, kGreen, ppd), 0.986661, 2e-6) << ppd;
}

TEST(FlipOfConstants, GrowsWithContrast) {
  double previous = 0;
  for (int grey = 1; grey < 256; ++grey) {
    const double error = between(kBlack, Rgb8(static_cast<std::uint8_t>(grey)));
    EXPECT_GT(error, previous) << grey;
    previous = error;
  }
}

/// Black, and white from column `first_white` on.
Image<Rgb8> step_at(std::uint32_t first_white) {
  Image<Rgb8> picture({8, 3}, kBlack);
  for (std::uint32_t y = 0; y < 3; ++y)
    for (std::uint32_t x = first_white; x < 8; ++x) picture.at(x, y) = kWhite;
  return picture;
}

TEST(Flip, OfEqualPicturesIsZero) {
  for (const double ppd : {kCoarse, 8.9, kMonitor})
    EXPECT_EQ(flip(step_at(3), step_at(3), ppd), Image<float>({8, 3}, 0.0f)) << ppd;
}

TEST(Flip, IsTheSameBothWays) {
  Image<Rgb8> coloured = step_at(5);
  coloured.at(2, 1) = kRed;
  for (const double ppd : {kCoarse, 8.9, kMonitor})
    EXPECT_EQ(flip(step_at(4), coloured, ppd), flip(coloured, step_at(4), ppd)) << ppd;
}

// Neither picture is blurred (kCoarse). At the point the colours are black and white: 0.967379. The point
// detector gives -1 along x and along y there, magnitude sqrt 2, in the other picture 0: feature difference
// (sqrt 2 / sqrt 2)^0.5 = 1, error 0.967379^0 = 1. Elsewhere the colours are equal, so the error is 0.
TEST(Flip, OfAPointIsOneThere) {
  const Image<Rgb8> empty({5, 5}, kBlack);
  Image<Rgb8> point = empty;
  point.at(2, 3) = kWhite;
  Image<float> expected({5, 5}, 0.0f);
  expected.at(2, 3) = 1;
  const Image<float> error = flip(empty, point, kCoarse);
  for (std::size_t i = 0; i < error.pixels.size(); ++i)
    EXPECT_NEAR(error.pixels[i], expected.pixels[i], 1e-6) << i;
}

// Column 4 is white before and black after. Its edge detector gives 1 in both pictures (p[5] - p[3]), its
// point detector (0 + 1) / 2 - 1 = -1/2 and (0 + 1) / 2 - 0 = 1/2, the same magnitude: features do not
// differ, the error is that of black and white. Other columns' colours do not differ.
TEST(Flip, OfAShiftedStepIsItsColumn) {
  const Image<float> error = flip(step_at(4), step_at(5), kCoarse);
  for (std::uint32_t y = 0; y < 3; ++y)
    for (std::uint32_t x = 0; x < 8; ++x) EXPECT_NEAR(error.at(x, y), x == 4 ? 0.967379 : 0, 2e-6) << x;
  EXPECT_NEAR(mean(error), 0.967379 / 8, 1e-6);
}

// A step against a constant white picture, unblurred, in its last black column: colours 0.967379; edge
// detector p[1] - p[-1] = 1, point detector 1/2, against 0 and 0: feature difference (1 / sqrt 2)^0.5 =
// 0.840896, error 0.967379^0.159104 = exp(0.159104 * -0.0331648) = 0.994737. Columns farther left have no
// feature.
TEST(Flip, FeaturesRaiseTheErrorOfColours) {
  const Image<float> error = flip(Image<Rgb8>({8, 3}, kWhite), step_at(4), kCoarse);
  EXPECT_NEAR(error.at(3, 1), 0.994737, 2e-6);
  EXPECT_NEAR(error.at(2, 1), 0.967379, 2e-6);
  EXPECT_NEAR(error.at(4, 1), 0.0, 1e-6);
}

// A white pixel among black ones, compared with white everywhere, without blur. The features differ as much
// as possible, as for a point, but the pixel itself has the same colour in both, so the error is 0.
TEST(Flip, IsZeroWhereColoursAreEqualWhateverTheFeatures) {
  Image<Rgb8> point({5, 5}, kBlack);
  point.at(2, 2) = kWhite;
  EXPECT_EQ(flip(Image<Rgb8>({5, 5}, kWhite), point, kCoarse).at(2, 2), 0);
}

TEST(Flip, FineDetailFadesWithPixelsPerDegree) {
  Image<Rgb8> board({32, 32}, kBlack);
  Image<Rgb8> inverse({32, 32}, kWhite);
  for (std::uint32_t y = 0; y < 32; ++y)
    for (std::uint32_t x = y % 2; x < 32; x += 2) std::swap(board.at(x, y), inverse.at(x, y));
  double previous = 1.1;
  for (const double ppd : {5.0, 40.0, 67.0, 150.0}) {
    const double error = flip(board, inverse, ppd).at(16, 16);
    EXPECT_LT(error, previous) << ppd;
    previous = error;
  }
  EXPECT_LT(previous, 1e-3);
}

TEST(Flip, LiesWithinZeroAndOneAtAnyPixelsPerDegree) {
  Image<Rgb8> a({7, 5}, kBlue), b({7, 5}, kGreen);
  for (std::size_t i = 0; i < a.pixels.size(); i += 2) {
    a.pixels[i] = kWhite;
    b.pixels[i] = kBlack;
  }
  for (const double ppd : {1e-6, 1e-3, 0.3, 1.0, 3.0, 24.390243902439025, 300.0, 1e5})
    for (const float e : flip(a, b, ppd).pixels) EXPECT_TRUE(e >= 0 && e <= 1) << e << " at " << ppd;
}

TEST(Flip, SeesAReferenceOnce) {
  const SeenPicture reference = see(step_at(4), 20);
  EXPECT_EQ(flip(reference, see(step_at(5), 20)), flip(step_at(4), step_at(5), 20));
}

TEST(Flip, OfEmptyPicturesIsEmpty) {
  const Image<float> error = flip(Image<Rgb8>(), Image<Rgb8>(), kMonitor);
  EXPECT_TRUE(error.pixels.empty());
  EXPECT_EQ(mean(error), 0);
}

TEST(FlipDeathTest, RefusesWhatCannotBeCompared) {
  const Image<Rgb8> wide({2, 1}), tall({1, 2});
  EXPECT_DEATH((void)flip(wide, tall, kMonitor), "one size");
  EXPECT_DEATH((void)flip(see(wide, 10), see(wide, 11)), "pixels a degree");
  EXPECT_DEATH((void)see(wide, 0), "pixels a degree");
  EXPECT_DEATH((void)see(wide, -10), "pixels a degree");
  EXPECT_DEATH((void)see(wide, std::numeric_limits<double>::quiet_NaN()), "pixels a degree");
  EXPECT_DEATH((void)see(wide, std::numeric_limits<double>::infinity()), "pixels a degree");
}

TEST(Mean, IsOverAllPixels) {
  Image<float> error({3, 1});
  error.pixels = {0.25f, 0.5f, 0.0f};
  EXPECT_DOUBLE_EQ(mean(error), 0.25);
}

}  // namespace
}  // namespace farshade
