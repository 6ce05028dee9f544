/// Shows errors as colours that a reader can rank: the lightness increases monotonically with the error.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// 0 is black and 1 is a light yellow. Values outside are clamped; NaN gives black. The colours are those of
/// magma (van der Walt and Smith, Matplotlib, CC0) at six even steps, with linear interpolation in sRGB.
[[nodiscard]] Image<Rgb8> heat_map(const Image<float>& error);

}  // namespace farshade
