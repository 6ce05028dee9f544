/// Filters a picture of one channel with kernels of one dimension, along its rows or its columns. Beyond the
/// border the border's pixel repeats.
///
/// A kernel is stored as weights of differences: of a neighbour and the centre if the kernel is even, of the
/// two neighbours at one distance if it is odd. So the result for a constant picture is exact.
#pragma once

#include <vector>

#include "stereo/image/image.h"

namespace farshade {

/// Result: `sum` p[0] + sum over k of sides[k-1] (p[k] + p[-k] - 2 p[0]). `sum` is the sum of all weights.
struct EvenKernel {
  float sum = 1;
  std::vector<float> sides;  ///< at distances 1, 2, ...
};

/// Result: sum over k of sides[k-1] (p[k] - p[-k]).
struct OddKernel {
  std::vector<float> sides;  ///< at distances 1, 2, ...
};

[[nodiscard]] Image<float> along_rows(const Image<float>& picture, const EvenKernel& kernel);
[[nodiscard]] Image<float> along_rows(const Image<float>& picture, const OddKernel& kernel);
[[nodiscard]] Image<float> along_columns(const Image<float>& picture, const EvenKernel& kernel);
[[nodiscard]] Image<float> along_columns(const Image<float>& picture, const OddKernel& kernel);

}  // namespace farshade
