/// A reference for the pose filters along one axis: they are linear systems, solved here in another way than
/// in the product. It computes in long double, with transitions by the matrix exponential (Taylor series,
/// scaling and squaring). The Kalman filter's process noise comes from Van Loan's augmented matrix over a
/// short step that is then doubled, because squaring that matrix would overflow: it contains e^(step / fade).
/// Measurements use Joseph's form.
/// Sources: C. F. Van Loan, "Computing integrals involving the matrix exponential", 1978; R. S. Bucy, P. D.
/// Joseph, "Filtering for stochastic processes with applications to guidance", 1968.
#pragma once

#include <array>
#include <map>

namespace farshade::stiff {

using Real = long double;
template <std::size_t N>
using Matrix = std::array<std::array<Real, N>, N>;

/// p' = v, v' = -v / fade + noise of density 1, over one step.
struct DampedReference {
  Real keep, travel_s, pp, pv, vv;
};
[[nodiscard]] DampedReference damped_reference(Real step_s, Real fade_s);

class KalmanReference {
 public:
  struct Tuning {
    Real fade_s, drive, noise, unseen_vv;
  };
  explicit KalmanReference(const Tuning& tuning)
      : tuning_(tuning), pp_(tuning.noise * tuning.noise), vv_(tuning.unseen_vv) {}

  /// Predicts the estimate over the step. The measurement afterwards is given as its difference from
  /// ahead(step).
  void step(Real step_s, Real error);
  [[nodiscard]] Real travel_s(Real lead_s) { return at(lead_s).travel_s; }
  [[nodiscard]] Real velocity() const { return v_; }
  [[nodiscard]] Real corrected() const { return corrected_; }
  [[nodiscard]] Real pp() const { return pp_; }
  [[nodiscard]] Real pv() const { return pv_; }
  [[nodiscard]] Real vv() const { return vv_; }

 private:
  const DampedReference& at(Real step_s);

  Tuning tuning_;
  Real v_ = 0, corrected_ = 0, pp_, pv_ = 0, vv_;
  std::map<Real, DampedReference> steps_;
};

}  // namespace farshade::stiff
