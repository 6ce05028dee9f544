/// Structural similarity: whether two pictures vary in the same way around each pixel.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// Mean SSIM of Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility to
/// structural similarity", 2004: an 11 x 11 Gaussian window with a deviation of 1.5 pixels, K1 = 0.01, K2 =
/// 0.03, at full size, on the luma (BT.601, as in the authors' programs, not rounded) of the sRGB values.
/// From -1 to 1; 1 for equal pictures and for empty ones.
///
/// Only windows that lie completely within the picture count. Along a side shorter than 11 pixels the window
/// is reduced to the largest odd length that fits. Both pictures have one size.
[[nodiscard]] double ssim(const Image<Rgb8>& a, const Image<Rgb8>& b);

}  // namespace farshade
