/// What shadows take away, as a picture that a video coder takes: delta encoding, biased to mid-grey (Cuervo
/// et al., "Kahawai: high-quality mobile gaming using GPU offload", MobiSys 2015).
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// (with - without) / 2 + 128, of each sRGB channel's level, rounded up at halves and cut off at 255. Both
/// have one size. `without` + 2 * (difference - 128) is `with` within one level.
[[nodiscard]] Image<Rgb8> difference_of(const Image<Rgb8>& with, const Image<Rgb8>& without);

}  // namespace farshade
