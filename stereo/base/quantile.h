/// Median, p95 and p99 of measured values: how every time and error here is reported.
#pragma once

#include <cstddef>
#include <vector>

namespace farshade {

struct Spread {
  std::size_t count = 0;
  double median = 0, p95 = 0, p99 = 0;
};

/// The q-quantile (0..1) by linear interpolation between closest ranks (Hyndman and Fan 1996, type 7).
/// 0 of no values.
[[nodiscard]] double quantile(std::vector<double> values, double q);

[[nodiscard]] Spread spread_of(std::vector<double> values);

}  // namespace farshade
