/// Median, p95 and p99 of measured values. All reports of times and errors use them.
#pragma once

#include <cstddef>
#include <vector>

namespace farshade {

struct Spread {
  std::size_t count = 0;
  double median = 0, p95 = 0, p99 = 0;
};

/// The q-quantile (0..1) by linear interpolation between closest ranks (Hyndman and Fan 1996, type 7).
/// Returns 0 if there are no values.
[[nodiscard]] double quantile(std::vector<double> values, double q);

[[nodiscard]] Spread spread_of(std::vector<double> values);

}  // namespace farshade
