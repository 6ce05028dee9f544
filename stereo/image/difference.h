/// Differences between the sRGB values of two pictures of the same size, over all pixels and channels.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// Mean squared difference, 0 to 255^2. Returns 0 for empty pictures.
[[nodiscard]] double mse(const Image<Rgb8>& a, const Image<Rgb8>& b);

/// 10 log10(255^2 / mse), decibels; infinite for equal pictures.
[[nodiscard]] double psnr_db(double mse);
[[nodiscard]] double psnr_db(const Image<Rgb8>& a, const Image<Rgb8>& b);

/// Eight times the absolute difference of each channel, at most 255.
[[nodiscard]] Image<Rgb8> difference_x8(const Image<Rgb8>& a, const Image<Rgb8>& b);

}  // namespace farshade
