/// The difference between a picture with and without shadows, as a picture for a video coder: delta encoding
/// with a bias of mid-grey (Cuervo et al., "Kahawai: high-quality mobile gaming using GPU offload", MobiSys
/// 2015).
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// (with - without) / 2 + 128 for the 8-bit level of each sRGB channel, halves rounded up, at most 255. Both
/// pictures have one size. `without` + 2 * (difference - 128) equals `with` within one level.
[[nodiscard]] Image<Rgb8> difference_of(const Image<Rgb8>& with, const Image<Rgb8>& without);

}  // namespace farshade
