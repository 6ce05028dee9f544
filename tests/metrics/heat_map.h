/// Errors as colours that a reader can rank: lightness grows with the error all along the map.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// 0 is black, 1 a light yellow; values outside, NaN too, take the nearer end (NaN: black). The colours are
/// those of magma (van der Walt and Smith, Matplotlib, CC0) at six even steps, linear in sRGB between them.
[[nodiscard]] Image<Rgb8> heat_map(const Image<float>& error);

}  // namespace farshade
