/// The covariance of a Kalman filter, for tests.
#pragma once

#include "stereo/head/kalman_filter.h"

namespace farshade {

/// Covariance of the error (p, v) of one component; pp * vv >= pv^2 up to rounding.
struct Covariance {
  double pp = 0, pv = 0, vv = 0;
};

inline Covariance expanded(const KalmanFilter::FactoredCovariance& factored) {
  const auto& [p, v_by_p, v_alone] = factored;
  return {.pp = p, .pv = v_by_p * p, .vv = v_alone + v_by_p * v_by_p * p};
}

}  // namespace farshade
