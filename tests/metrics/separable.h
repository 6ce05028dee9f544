/// A picture of one channel run through kernels of one dimension, along its rows or its columns. Beyond a
/// border the border's pixel repeats.
///
/// A kernel is kept as its weights on differences: of a neighbour from the centre where it is even, of the
/// two neighbours at one distance from each other where it is odd. So a constant comes out exactly as it
/// must.
#pragma once

#include <vector>

#include "stereo/image/image.h"

namespace farshade {

/// Result: `sum` p[0] + sum over k of sides[k-1] (p[k] + p[-k] - 2 p[0]); `sum` is what all weights add up
/// to.
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
