#include "stereo/math/damped_motion.h"

#include <algorithm>
#include <cmath>

namespace farshade {
namespace {

// The closed forms below lose digits to cancellation under these; the series used there are summed until
// their terms fall below 1e-18 of the first.
constexpr double kSmoothedSeriesBelow = 0.5, kSpreadSeriesBelow = 0.5;
constexpr int kLastTerm = 24;

/// (2x - 3 + 4 e^-x - e^-2x) / (2 x^3); 1/3 at 0. Times step^3 the variance of the way.
double way_variance(double x) {
  if (x >= kSpreadSeriesBelow)
    return (2.0 * x - 3.0 + 4.0 * std::exp(-x) - std::exp(-2.0 * x)) / (2.0 * x * x * x);
  double sum = 0.0, power = 1.0 / 6.0, two_to_k = 8.0;  // (-x)^(k - 3) / k!
  for (int k = 3; k <= kLastTerm; ++k) {
    sum += power * (two_to_k - 4.0);
    power *= -x / (k + 1);
    two_to_k *= 2.0;
  }
  return 0.5 * sum;
}

}  // namespace

double mean_decay(double x) {
  return x > 0 ? -std::expm1(-x) / x : 1.0;
}

double twice_smoothed(double x) {
  if (x >= kSmoothedSeriesBelow) return 1.0 - std::exp(-x) * (1.0 + x);
  double sum = 0.0, power = 0.5 * x * x;  // (-x)^k / k!
  for (int k = 2; k <= kLastTerm; ++k) {
    sum += power * (k - 1);
    power *= -x / (k + 1);
  }
  return sum;
}

double damped_travel_s(double step_s, double fade_s) {
  return std::min({step_s * mean_decay(step_s / fade_s), step_s, fade_s});  // rounding may exceed by an ulp
}

DampedStep damped_step(double step_s, double fade_s) {
  const double x = step_s / fade_s, mean = mean_decay(x);
  return {.keep = std::exp(-x),
          .travel_s = damped_travel_s(step_s, fade_s),
          .pp = step_s * step_s * step_s * way_variance(x),
          .pv = 0.5 * step_s * step_s * mean * mean,
          .vv = step_s * mean_decay(2.0 * x)};
}

}  // namespace farshade
