#include "stereo/math/twist.h"

#include <cmath>
#include <initializer_list>

namespace farshade {
namespace {

// Below this squared angle, the closed forms lose digits to cancellation. There, the first omitted term of
// each series is below 1e-16 of the sum.
constexpr double kSeriesBelow = 0.25;

/// (1 - cos a) / a^2, without cancellation.
double one_minus_cos_over_square(double angle) {
  const double half = 0.5 * angle;
  const double sinc = half < 1e-4 ? 1.0 - half * half / 6.0 : std::sin(half) / half;
  return 0.5 * sinc * sinc;
}

/// (a - sin a) / a^3
double angle_minus_sin_over_cube(double angle, double a2) {
  if (a2 >= kSeriesBelow) return (angle - std::sin(angle)) / (a2 * angle);
  double sum = 0.0;
  for (const double over : {210.0, 156.0, 110.0, 72.0, 42.0, 20.0}) sum = (1.0 - sum) * a2 / over;
  return (1.0 - sum) / 6.0;
}

/// (1 - (a/2) / tan(a/2)) / a^2, by its Bernoulli series near zero.
double one_minus_half_cot_over_square(double angle, double a2) {
  if (a2 >= kSeriesBelow) return (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / a2;
  double sum = 0.0;
  for (const double c : {1.0 / 74724249600.0, 691.0 / 1307674368000.0, 1.0 / 47900160.0, 1.0 / 1209600.0,
                         1.0 / 30240.0, 1.0 / 720.0, 1.0 / 12.0})
    sum = sum * a2 + c;
  return sum;
}

}  // namespace

glm::dvec3 screw_translation(const Twist& motion) {
  const glm::dvec3& w = motion.angular;
  const double a2 = glm::dot(w, w), angle = std::sqrt(a2);
  const glm::dvec3 once = glm::cross(w, motion.linear);
  return motion.linear + once * one_minus_cos_over_square(angle) +
         glm::cross(w, once) * angle_minus_sin_over_cube(angle, a2);
}

glm::dvec3 screw_linear(const glm::dvec3& w, const glm::dvec3& translation) {
  const double a2 = glm::dot(w, w), angle = std::sqrt(a2);
  const glm::dvec3 once = glm::cross(w, translation);
  return translation - once * 0.5 + glm::cross(w, once) * one_minus_half_cot_over_square(angle, a2);
}

}  // namespace farshade
