#include "stereo/head/damped_motion.h"

#include <algorithm>
#include <cmath>

namespace farshade {
namespace {

// Below this x the series loses fewer digits than the closed form; here both lose at most one. The series
// ends when a term is below kNegligible of the first.
constexpr double kSeriesBelow = 1.25;
constexpr double kNegligible = 1e-18;

/// (2x - 3 + 4 e^-x - e^-2x) / (2 x^3); 1/3 at 0. Times step^3, it is the variance of p.
double distance_variance(double x) {
  if (x >= kSeriesBelow) return (2.0 * x - 3.0 + 4.0 * std::exp(-x) - std::exp(-2.0 * x)) / (2.0 * x * x * x);
  double sum = 0.0, power = 1.0 / 6.0, two_to_k = 8.0;  // (-x)^(k - 3) / k!
  for (int k = 3; std::abs(power) * two_to_k > kNegligible; ++k) {
    sum += power * (two_to_k - 4.0);
    power *= -x / (k + 1);
    two_to_k *= 2.0;
  }
  return 0.5 * sum;
}

double travel_s(double step_s, double fade_s, double mean) {
  return std::min({step_s * mean, step_s, fade_s});  // rounding may exceed the limits by an ulp
}

}  // namespace

double mean_decay(double x) {
  return x > 0 ? -std::expm1(-x) / x : 1.0;
}

double damped_travel_s(double step_s, double fade_s) {
  return travel_s(step_s, fade_s, mean_decay(step_s / fade_s));
}

DampedStep damped_step(double step_s, double fade_s) {
  const double x = step_s / fade_s, mean = mean_decay(x), keep = std::exp(-x);
  return {.keep = keep,
          .travel_s = travel_s(step_s, fade_s, mean),
          .pp = step_s * step_s * step_s * distance_variance(x),
          .pv = 0.5 * step_s * step_s * mean * mean,
          .vv = 0.5 * step_s * mean * (1.0 + keep)};
}

}  // namespace farshade
