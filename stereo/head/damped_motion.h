/// A velocity that decays to 0 and is driven by white noise (an Ornstein-Uhlenbeck process), and its
/// integral: v' = -v / fade + noise, p' = v. One step is the exact solution of this stiff linear system, for
/// any ratio of step to decay time. Source: G. E. Uhlenbeck, L. S. Ornstein, "On the theory of the Brownian
/// motion", 1930; D. T. Gillespie, "Exact numerical simulation of the Ornstein-Uhlenbeck process and its
/// integral", 1996.
#pragma once

namespace farshade {

/// (1 - e^-x) / x for x >= 0; 1 at 0.
[[nodiscard]] double mean_decay(double x);

/// The distance that a velocity of 1 covers in step_s >= 0 while it decays: fade_s (1 - e^-(step / fade)). At
/// most step_s and fade_s.
[[nodiscard]] double damped_travel_s(double step_s, double fade_s);

/// The effect of `step_s` >= 0 on (p, v), for noise of spectral density 1.
struct DampedStep {
  double keep = 1;                ///< v becomes keep * v
  double travel_s = 0;            ///< p grows by travel_s * v (damped_travel_s)
  double pp = 0, pv = 0, vv = 0;  ///< covariance of (p, v) that the noise adds, s^3, s^2, s
};
[[nodiscard]] DampedStep damped_step(double step_s, double fade_s);

}  // namespace farshade
