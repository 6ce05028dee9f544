#include "stereo/metrics/ssim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "stereo/base/check.h"

namespace farshade {
namespace {

constexpr double kC1 = 0.01 * 255 * 0.01 * 255, kC2 = 0.03 * 255 * 0.03 * 255;

/// The window along a side of `length` > 0 pixels.
std::vector<double> window(std::size_t length) {
  const std::size_t radius = std::min<std::size_t>(5, (length - 1) / 2);
  std::vector<double> weights(2 * radius + 1);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double x = static_cast<double>(i) - static_cast<double>(radius);
    weights[i] = std::exp(-x * x / (2 * 1.5 * 1.5));
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

std::vector<double> luma(const Image<Rgb8>& picture) {
  std::vector<double> values(picture.pixels.size());
  std::ranges::transform(picture.pixels, values.begin(),
                         [](Rgb8 p) { return 0.299 * p.r + 0.587 * p.g + 0.114 * p.b; });
  return values;
}

/// Weighted sums over a window, one array entry for each pixel of a row. The formula needs only the sum of
/// the two variances, so four sums suffice.
struct Sums {
  std::vector<double> a, b, squares, product;  ///< of a, b, a^2 + b^2, a b
  explicit Sums(std::size_t width) : a(width), b(width), squares(width), product(width) {}
  [[nodiscard]] std::array<std::vector<double>*, 4> all() { return {&a, &b, &squares, &product}; }
};

/// Sums over the rows from `a` and `b` on.
void sum_down(const double* a, const double* b, const std::vector<double>& weights, Sums& sums) {
  const std::size_t width = sums.a.size();
  for (std::vector<double>* sum : sums.all()) std::ranges::fill(*sum, 0.0);
  for (const double weight : weights) {
    for (std::size_t x = 0; x < width; ++x) {
      const double wa = weight * a[x], wb = weight * b[x];
      sums.a[x] += wa;
      sums.b[x] += wb;
      sums.squares[x] += wa * a[x] + wb * b[x];
      sums.product[x] += wa * b[x];
    }
    a += width;
    b += width;
  }
}

void sum_across(const std::vector<double>& column, const std::vector<double>& weights,
                std::vector<double>& sum) {
  std::ranges::fill(sum, 0.0);
  for (std::size_t k = 0; k < weights.size(); ++k)
    for (std::size_t x = 0; x < sum.size(); ++x) sum[x] += weights[k] * column[x + k];
}

double similarity(double mean_a, double mean_b, double squares, double product) {
  const double mean_squares = mean_a * mean_a + mean_b * mean_b, mean_product = mean_a * mean_b;
  return (2 * mean_product + kC1) * (2 * (product - mean_product) + kC2) /
         ((mean_squares + kC1) * (squares - mean_squares + kC2));
}

}  // namespace

double ssim(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  check(a.size == b.size, "compared pictures have one size");
  if (a.pixels.empty()) return 1;
  const std::size_t width = a.size.width, height = a.size.height;
  const std::vector<double> luma_a = luma(a), luma_b = luma(b);
  const std::vector<double> across = window(width), down = window(height);
  const std::size_t columns = width - across.size() + 1, rows = height - down.size() + 1;
  Sums column_sums(width), sums(columns);
  double total = 0;
  for (std::size_t y = 0; y < rows; ++y) {
    sum_down(luma_a.data() + y * width, luma_b.data() + y * width, down, column_sums);
    for (std::size_t i = 0; i < 4; ++i) sum_across(*column_sums.all()[i], across, *sums.all()[i]);
    for (std::size_t x = 0; x < columns; ++x)
      total += similarity(sums.a[x], sums.b[x], sums.squares[x], sums.product[x]);
  }
  return total / static_cast<double>(rows * columns);
}

}  // namespace farshade
