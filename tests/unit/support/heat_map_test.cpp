#include "tests/support/heat_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace farshade {
namespace {

Rgb8 colour_of(float error) {
  return heat_map(Image<float>({1, 1}, error)).at(0, 0);
}

double lightness(Rgb8 colour) {
  double y = 0;
  const double weights[] = {0.2126, 0.7152, 0.0722};
  for (int i = 0; i < 3; ++i) {
    const double c = colour[i] / 255.0;
    y += weights[i] * (c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}

TEST(HeatMap, GoesFromBlackToLightYellow) {
  EXPECT_EQ(colour_of(0), Rgb8(0, 0, 4));
  EXPECT_EQ(colour_of(0.1f), Rgb8(30, 8, 58));  // midway between (0, 0, 4) and (59, 15, 112), rounded
  EXPECT_EQ(colour_of(0.2f), Rgb8(59, 15, 112));
  EXPECT_EQ(colour_of(0.4f), Rgb8(140, 41, 129));
  EXPECT_EQ(colour_of(0.6f), Rgb8(222, 73, 104));
  EXPECT_EQ(colour_of(0.8f), Rgb8(254, 159, 109));
  EXPECT_EQ(colour_of(1), Rgb8(252, 253, 191));
}

TEST(HeatMap, GetsLighterByEvenSteps) {
  for (int i = 0; i < 32; ++i) {
    const double step = lightness(colour_of(static_cast<float>(i + 1) / 32)) -
                        lightness(colour_of(static_cast<float>(i) / 32));
    EXPECT_GT(step, 0.4 * 98 / 32) << i;
    EXPECT_LT(step, 1.4 * 98 / 32) << i;
  }
}

TEST(HeatMap, TakesTheNearerEndOutside) {
  EXPECT_EQ(colour_of(-0.1f), colour_of(0));
  EXPECT_EQ(colour_of(1.1f), colour_of(1));
  EXPECT_EQ(colour_of(std::numeric_limits<float>::infinity()), colour_of(1));
  EXPECT_EQ(colour_of(std::numeric_limits<float>::quiet_NaN()), colour_of(0));
}

TEST(HeatMap, KeepsPlaces) {
  Image<float> error({3, 2}, 0.0f);
  error.at(2, 1) = 1;
  Image<Rgb8> expected({3, 2}, {0, 0, 4});
  expected.at(2, 1) = {252, 253, 191};
  EXPECT_EQ(heat_map(error), expected);
}

}  // namespace
}  // namespace farshade
