/// How far two pictures are apart, over all pixels and channels of the sRGB values. Both have the same size.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// Mean of the squared differences, 0 to 255 squared. 0 of empty pictures.
[[nodiscard]] double mse(const Image<Rgb8>& a, const Image<Rgb8>& b);

/// 10 log10(255^2 / mse), decibels; infinite where the pictures are equal.
[[nodiscard]] double psnr_db(double mse);
[[nodiscard]] double psnr_db(const Image<Rgb8>& a, const Image<Rgb8>& b);

/// Eight times the absolute difference of each channel, cut off at 255.
[[nodiscard]] Image<Rgb8> difference_x8(const Image<Rgb8>& a, const Image<Rgb8>& b);

}  // namespace farshade
