#include "tests/unit/head/stiff_reference.h"

#include <algorithm>
#include <cmath>

namespace farshade::stiff {
namespace {

/// Below this norm 20 terms of the series leave less than 1e-30.
constexpr Real kSmall = 0.125L;
constexpr int kTerms = 20;

template <std::size_t N>
Matrix<N> identity() {
  Matrix<N> one{};
  for (std::size_t i = 0; i < N; ++i) one[i][i] = 1;
  return one;
}

template <std::size_t N>
Matrix<N> product(const Matrix<N>& a, const Matrix<N>& b) {
  Matrix<N> ab{};
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j < N; ++j)
      for (std::size_t k = 0; k < N; ++k) ab[i][j] += a[i][k] * b[k][j];
  return ab;
}

template <std::size_t N>
Matrix<N> scaled(Matrix<N> a, Real by) {
  for (auto& row : a)
    for (Real& value : row) value *= by;
  return a;
}

template <std::size_t N>
Real norm(const Matrix<N>& a) {
  Real largest = 0;
  for (const auto& row : a) {
    Real sum = 0;
    for (const Real value : row) sum += std::abs(value);
    largest = std::max(largest, sum);
  }
  return largest;
}

/// For a norm up to kSmall: Horner's method, smallest terms first.
template <std::size_t N>
Matrix<N> exponential_series(const Matrix<N>& a) {
  Matrix<N> sum = identity<N>();
  for (int k = kTerms; k >= 1; --k) {
    sum = scaled(product(a, sum), Real(1) / k);
    for (std::size_t i = 0; i < N; ++i) sum[i][i] += 1;
  }
  return sum;
}

int halvings(Real size) {
  return size > kSmall ? static_cast<int>(std::ceil(std::log2(size / kSmall))) : 0;
}

/// Van Loan: exp([-A G; 0 A^T] t) = [. G2; 0 F3], transition F3^T, noise F3^T G2.
DampedReference van_loan(Real step_s, Real fade_s) {
  const Real rate = 1 / fade_s;
  const Matrix<4> augmented{{{0, -1, 0, 0}, {0, rate, 0, 1}, {0, 0, 0, 0}, {0, 0, 1, -rate}}};
  const Matrix<4> e = exponential_series(scaled(augmented, step_s));
  const auto noise = [&](std::size_t i, std::size_t j) {
    return e[2][2 + i] * e[0][2 + j] + e[3][2 + i] * e[1][2 + j];
  };
  return {.keep = e[3][3], .travel_s = e[3][2], .pp = noise(0, 0), .pv = noise(0, 1), .vv = noise(1, 1)};
}

DampedReference twice(const DampedReference& s) {
  const Real pv = s.pv + s.travel_s * s.vv;
  return {.keep = s.keep * s.keep,
          .travel_s = s.travel_s + s.keep * s.travel_s,
          .pp = 2 * s.pp + s.travel_s * (s.pv + pv),
          .pv = s.keep * pv + s.pv,
          .vv = s.keep * s.keep * s.vv + s.vv};
}

}  // namespace

DampedReference damped_reference(Real step_s, Real fade_s) {
  const int times = halvings(step_s * (2 + 1 / fade_s));
  DampedReference step = van_loan(std::ldexp(step_s, -times), fade_s);
  for (int i = 0; i < times; ++i) step = twice(step);
  return step;
}

const DampedReference& KalmanReference::at(Real step_s) {
  const auto known = steps_.find(step_s);
  return known != steps_.end()
             ? known->second
             : steps_.emplace(step_s, damped_reference(step_s, tuning_.fade_s)).first->second;
}

void KalmanReference::step(Real step_s, Real error) {
  const DampedReference& s = at(step_s);
  const Real q = tuning_.drive, r = tuning_.noise * tuning_.noise;
  const Real p_p = pp_ + 2 * s.travel_s * pv_ + s.travel_s * s.travel_s * vv_ + q * s.pp;
  const Real p_v = s.keep * (pv_ + s.travel_s * vv_) + q * s.pv;
  const Real v_v = s.keep * s.keep * vv_ + q * s.vv;

  const Real to_p = p_p / (p_p + r), to_v = p_v / (p_p + r), left = r / (p_p + r);  // left = 1 - to_p
  pp_ = left * left * p_p + to_p * to_p * r;
  pv_ = left * (p_v - to_v * p_p) + to_p * to_v * r;
  vv_ = v_v - 2 * to_v * p_v + to_v * to_v * (p_p + r);
  v_ = s.keep * v_ + to_v * error;
  corrected_ = to_p * error;
}

}  // namespace farshade::stiff
