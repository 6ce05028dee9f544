/// Structural similarity: whether two pictures vary alike around each pixel.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// Mean SSIM of Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility to
/// structural similarity", 2004: 11 x 11 Gaussian window of deviation 1.5 pixels, K1 = 0.01, K2 = 0.03, at
/// full size, on the luma (BT.601, as the authors' programs, not rounded) of the sRGB values. From -1 to 1; 1
/// of equal pictures and of empty ones.
///
/// Only windows that lie whole within the picture count. Along a side shorter than 11 pixels the window is
/// cut to the largest odd length that fits. Both pictures have one size.
[[nodiscard]] double ssim(const Image<Rgb8>& a, const Image<Rgb8>& b);

}  // namespace farshade
