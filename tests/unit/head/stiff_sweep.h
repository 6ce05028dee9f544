/// Every pose filter against its closed form (math_stiff_reference.h) over time constants from 1e-5 to 1e3 s
/// and steps from 1e-4 to 1 s: a head that rests, goes, jumps, stands, comes back and sways, with gaps of ten
/// steps, bursts of a thousandth of one, repeated and backward stamps, all through Predictor. Once it walks
/// at 1 m/s, once it turns at 1,000 degrees/s.
#pragma once

#include <string>
#include <vector>

namespace farshade::stiff {

/// The largest error of one figure over the whole grid, and where that was.
struct GridError {
  std::string filter, figure;
  double bound = 0, largest = 0;
  double step_s = 0, constant_s = 0;

  void add(double error, double at_step_s, double at_constant_s);
};

struct Grid {
  std::vector<double> steps_s, constants_s;
};
/// Each decade in `parts`.
[[nodiscard]] Grid whole_grid(int parts);

/// damped_step alone.
[[nodiscard]] std::vector<GridError> step_errors(const Grid& grid);
[[nodiscard]] std::vector<GridError> hold_errors(const Grid& grid);
[[nodiscard]] std::vector<GridError> kalman_errors(const Grid& grid);

/// All of them, each over as fine a grid as takes well under a second.
[[nodiscard]] std::vector<GridError> all_stiff_errors();

}  // namespace farshade::stiff
