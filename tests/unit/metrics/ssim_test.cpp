#include "stereo/metrics/ssim.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace farshade {
namespace {

constexpr double kC1 = 6.5025, kC2 = 58.5225;  // (0.01 * 255)^2, (0.03 * 255)^2

Image<Rgb8> grey(Extent size, std::uint8_t value) {
  return Image<Rgb8>(size, Rgb8(value));
}

/// Greys `even` and `odd` by the parity of x + y.
Image<Rgb8> board(Extent size, std::uint8_t even, std::uint8_t odd) {
  Image<Rgb8> picture = grey(size, even);
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 1 - y % 2; x < size.width; x += 2) picture.at(x, y) = Rgb8(odd);
  return picture;
}

Image<Rgb8> noise(Extent size, std::mt19937& random) {
  Image<Rgb8> picture(size);
  for (Rgb8& p : picture.pixels) p = Rgb8(random() % 256, random() % 256, random() % 256);
  return picture;
}

// Without variance the second factor is C2 / C2: SSIM = (2 a b + C1) / (a^2 + b^2 + C1).
TEST(Ssim, OfConstantsIsInClosedForm) {
  EXPECT_NEAR(ssim(grey({20, 12}, 0), grey({20, 12}, 255)), kC1 / (65025 + kC1), 1e-12);
  EXPECT_NEAR(ssim(grey({20, 12}, 100), grey({20, 12}, 110)), (22000 + kC1) / (22100 + kC1), 1e-12);
  // Luma of red is 0.299 * 255 = 76.245, of green 0.587 * 255 = 149.685.
  EXPECT_NEAR(ssim(Image<Rgb8>({11, 11}, {255, 0, 0}), Image<Rgb8>({11, 11}, {0, 255, 0})),
              (2 * 76.245 * 149.685 + kC1) / (76.245 * 76.245 + 149.685 * 149.685 + kC1), 1e-12);
}

TEST(Ssim, OfEqualPicturesIsOne) {
  std::mt19937 random(5);
  for (const Extent size : {Extent{1, 1}, Extent{2, 3}, Extent{10, 11}, Extent{33, 17}}) {
    const Image<Rgb8> picture = noise(size, random);
    EXPECT_EQ(ssim(picture, picture), 1) << size.width;
  }
  EXPECT_EQ(ssim(Image<Rgb8>(), Image<Rgb8>()), 1);
}

// Over a Gaussian window with a deviation of 1.5 pixels, a checkerboard is half of each grey within 1e-8.
// Both means are 127.5. The variances are s^2 and t^2 for boards of 127.5 +- s and 127.5 +- t. The covariance
// is s t, negative if one board is inverted.
TEST(Ssim, OfCheckerboardsIsInClosedForm) {
  const Extent size{30, 30};
  const auto expected = [](double s, double t) { return (2 * s * t + kC2) / (s * s + t * t + kC2); };
  EXPECT_NEAR(ssim(board(size, 0, 255), board(size, 255, 0)), expected(127.5, -127.5), 1e-5);
  EXPECT_LT(expected(127.5, -127.5), -0.99);
  EXPECT_NEAR(ssim(board(size, 0, 255), board(size, 64, 191)), expected(127.5, 63.5), 1e-5);
  EXPECT_NEAR(ssim(board(size, 120, 135), board(size, 128, 127)), expected(7.5, -0.5), 1e-5);
}

TEST(Ssim, OfInvertedNoiseIsNegative) {
  std::mt19937 random(6);
  const Image<Rgb8> picture = noise({40, 40}, random);
  Image<Rgb8> inverted = picture;
  for (Rgb8& p : inverted.pixels) p = Rgb8(255) - p;
  EXPECT_LT(ssim(picture, inverted), -0.9);
}

TEST(Ssim, FallsAsNoiseGrows) {
  double previous = 1;
  for (const std::uint32_t amplitude : {4u, 16u, 64u}) {
    std::mt19937 random(7);
    Image<Rgb8> noisy = board({40, 40}, 80, 170);
    for (Rgb8& p : noisy.pixels) p += Rgb8(static_cast<std::uint8_t>(random() % amplitude));
    const double similar = ssim(board({40, 40}, 80, 170), noisy);
    EXPECT_LT(similar, previous) << amplitude;
    previous = similar;
  }
}

/// The paper's equations 14 to 16, one window after another, with moments about the mean.
double literal_ssim(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  const int width = static_cast<int>(a.size.width), height = static_cast<int>(a.size.height);
  const int rx = std::min(5, (width - 1) / 2), ry = std::min(5, (height - 1) / 2);
  const auto luma = [](const Image<Rgb8>& picture, int x, int y) {
    const Rgb8 p = picture.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
    return 0.299 * p.r + 0.587 * p.g + 0.114 * p.b;
  };
  double total = 0, windows = 0;
  for (int cy = ry; cy < height - ry; ++cy)
    for (int cx = rx; cx < width - rx; ++cx) {
      const auto average = [&](auto value) {
        double sum = 0, weights = 0;
        for (int y = -ry; y <= ry; ++y)
          for (int x = -rx; x <= rx; ++x) {
            const double w = std::exp(-(x * x + y * y) / (2 * 1.5 * 1.5));
            sum += w * value(luma(a, cx + x, cy + y), luma(b, cx + x, cy + y));
            weights += w;
          }
        return sum / weights;
      };
      const double ma = average([](double p, double) { return p; });
      const double mb = average([](double, double q) { return q; });
      const double va = average([&](double p, double) { return (p - ma) * (p - ma); });
      const double vb = average([&](double, double q) { return (q - mb) * (q - mb); });
      const double cov = average([&](double p, double q) { return (p - ma) * (q - mb); });
      total += (2 * ma * mb + kC1) * (2 * cov + kC2) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
      windows += 1;
    }
  return total / windows;
}

TEST(Ssim, IsWhatThePapersEquationsGive) {
  for (std::uint32_t seed = 1; seed <= 3; ++seed)
    for (const Extent size :
         {Extent{1, 1}, Extent{1, 9}, Extent{4, 3}, Extent{7, 12}, Extent{11, 11}, Extent{25, 19}}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << size.width << " x " << size.height);
      std::mt19937 random(seed);
      const Image<Rgb8> a = noise(size, random);
      Image<Rgb8> b = a;
      for (Rgb8& p : b.pixels)
        if (random() % 2 == 0) p = Rgb8(static_cast<std::uint8_t>(random() % 256));
      EXPECT_NEAR(ssim(a, b), literal_ssim(a, b), 1e-9);
      EXPECT_NEAR(ssim(b, a), ssim(a, b), 1e-12);
    }
}

TEST(SsimDeathTest, RefusesUnequalSizes) {
  EXPECT_DEATH((void)ssim(grey({2, 1}, 0), grey({1, 2}, 0)), "one size");
}

}  // namespace
}  // namespace farshade
