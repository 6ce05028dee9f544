/// Compares every pose filter with its closed form (stiff_reference.h), over time constants from 1e-5 to 1e3
/// s and steps from 1e-4 to 1 s. The head rests, moves, jumps, stands, comes back and sways, with gaps of ten
/// steps, bursts of a thousandth of a step, and repeated and backward stamps, all through Predictor. It walks
/// at 1 m/s in one motion and turns at 1,000 degrees/s in the other.
#pragma once

#include <string>
#include <vector>

namespace farshade::stiff {

/// The largest error of one figure over the whole grid, and the place of that error.
struct GridError {
  std::string filter, figure;
  double bound = 0, largest = 0;
  double step_s = 0, constant_s = 0;

  void add(double error, double at_step_s, double at_constant_s);
};

struct Grid {
  std::vector<double> steps_s, constants_s;
};
/// Divides each decade into `parts`.
[[nodiscard]] Grid whole_grid(int parts);

/// Only damped_step.
[[nodiscard]] std::vector<GridError> step_errors(const Grid& grid);
[[nodiscard]] std::vector<GridError> hold_errors(const Grid& grid);
[[nodiscard]] std::vector<GridError> kalman_errors(const Grid& grid);

/// All errors, each over a grid fine enough to take well under a second.
[[nodiscard]] std::vector<GridError> all_stiff_errors();

}  // namespace farshade::stiff
