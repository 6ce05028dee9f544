#include "stereo/image/mip_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace farshade {
namespace {

double light_of(std::uint8_t code) {
  const double c = code / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// The mean light of one channel.
double mean_light(std::span<const Rgba8> pixels, int channel) {
  double sum = 0;
  for (const Rgba8& pixel : pixels) sum += light_of(pixel[channel]);
  return sum / static_cast<double>(pixels.size());
}

Image<Rgba8> noise(Extent size) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> code(0, 255);
  Image<Rgba8> image(size);
  for (Rgba8& pixel : image.pixels)
    for (int c = 0; c < 4; ++c) pixel[c] = static_cast<std::uint8_t>(code(random));
  return image;
}

TEST(MipLevels, AreHalfAsLargeDownToOnePixel) {
  EXPECT_EQ(mip_count({1, 1}), 1u);
  EXPECT_EQ(mip_count({5, 2}), 3u);
  EXPECT_EQ(mip_count({256, 1}), 9u);
  EXPECT_EQ(next_mip({5, 2}), (Extent{2, 1}));
  EXPECT_EQ(next_mip({2, 1}), (Extent{1, 1}));
  EXPECT_EQ(mip_pixels({5, 2}), 10u + 2 + 1);
  EXPECT_EQ(smaller_levels(Image<Rgba8>({5, 2})).size(), 3u);
  EXPECT_TRUE(smaller_levels(Image<Rgba8>({1, 1})).empty());
}

TEST(MipLevels, AverageLightNotCodes) {
  Image<Rgba8> image({2, 2}, Rgba8(0, 0, 0, 0));
  image.at(0, 0) = image.at(1, 1) = Rgba8(255, 100, 10, 255);
  // Half the light: 188 of white; code 100 is light 0.1274, half of it code 71; code 10 is in the linear
  // part.
  EXPECT_EQ(smaller_levels(image), std::vector<Rgba8>{Rgba8(188, 71, 5, 128)});
}

TEST(MipLevels, KeepEveryGreyInEveryLevel) {
  for (int code = 0; code < 256; ++code) {
    const Rgba8 grey(static_cast<std::uint8_t>(code));
    const std::vector<Rgba8> levels = smaller_levels(Image<Rgba8>({7, 5}, grey));
    EXPECT_EQ(std::ranges::count(levels, grey), std::ssize(levels)) << code;
  }
}

TEST(MipLevels, OddSidesLoseNoPixelAndNoLight) {
  for (const Extent size : {Extent{64, 64}, Extent{63, 64}, Extent{65, 33}, Extent{127, 1}, Extent{1, 9}}) {
    const Image<Rgba8> image = noise(size);
    const std::vector<Rgba8> levels = smaller_levels(image);
    const std::span<const Rgba8> next(levels.data(), next_mip(size).pixels());
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(mean_light(next, channel), mean_light(image.pixels, channel), 0.004)
          << size.width << "x" << size.height;
  }
}

/// Three pixels become one: a third of each. Five become two: 2/5 of the first two, 1/5 of the middle one.
TEST(MipLevels, WeighOddSidesByTheAreaCovered) {
  Image<Rgba8> five({5, 1}, Rgba8(0, 0, 0, 0));
  for (std::uint32_t x = 0; x < 5; ++x) five.at(x, 0).a = static_cast<std::uint8_t>(50 * x);
  const std::vector<Rgba8> levels = smaller_levels(five);
  ASSERT_EQ(levels.size(), 3u);
  EXPECT_EQ(levels[0].a, 40);   // (2 * 0 + 2 * 50 + 1 * 100) / 5
  EXPECT_EQ(levels[1].a, 160);  // (1 * 100 + 2 * 150 + 2 * 200) / 5
  EXPECT_EQ(levels[2].a, 100);
}

TEST(MipLevels, KeepRowsApart) {
  Image<Rgba8> image({2, 4}, Rgba8(0));
  for (std::uint32_t x = 0; x < 2; ++x) image.at(x, 2) = image.at(x, 3) = Rgba8(255);
  const std::vector<Rgba8> levels = smaller_levels(image);
  EXPECT_EQ(levels, (std::vector<Rgba8>{Rgba8(0), Rgba8(255), Rgba8(188, 188, 188, 128)}));
}

}  // namespace
}  // namespace farshade
