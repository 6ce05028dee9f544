#include "stereo/base/quantile.h"

#include <algorithm>
#include <cmath>

namespace farshade {
namespace {

double sorted_quantile(const std::vector<double>& sorted, double q) {
  if (sorted.empty()) return 0;
  const double rank = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(rank));
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], rank - static_cast<double>(below));
}

}  // namespace

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return sorted_quantile(values, q);
}

Spread spread_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values.size(), sorted_quantile(values, 0.5), sorted_quantile(values, 0.95),
          sorted_quantile(values, 0.99)};
}

}  // namespace farshade
