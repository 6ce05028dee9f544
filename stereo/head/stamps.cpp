#include "stereo/head/stamps.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "stereo/base/quantile.h"

namespace farshade {

std::string_view to_string(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::Seconds:
      return "s";
    case TimeUnit::Milliseconds:
      return "ms";
    case TimeUnit::Microseconds:
      return "us";
    case TimeUnit::Nanoseconds:
      break;
  }
  return "ns";
}

double rate_hz(const std::vector<double>& stamps, TimeUnit unit) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i)
    if (stamps[i] > stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
  if (steps.empty()) return 0;
  return std::pow(10.0, 9 - static_cast<int>(unit)) / quantile(std::move(steps), 0.5);
}

std::optional<TimeUnit> unit_of(const std::vector<double>& stamps, TimeUnit usual) {
  constexpr double k2000_ns = 946'684'800e9, k2100_ns = 4'102'444'800e9;
  std::optional<TimeUnit> best;
  const auto merit = [&](TimeUnit unit) {
    const double first_ns = stamps.front() * std::pow(10.0, static_cast<int>(unit));
    return std::tuple(first_ns > k2000_ns && first_ns < k2100_ns, unit == usual,
                      -std::abs(std::log(rate_hz(stamps, unit) / 100)));
  };
  for (const TimeUnit unit : kTimeUnits)
    if (is_plausible(rate_hz(stamps, unit)) && (!best || merit(unit) > merit(*best))) best = unit;
  return best;
}

}  // namespace farshade
