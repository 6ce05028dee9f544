#include "stereo/image/difference_picture.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {

Image<Rgb8> difference_of(const Image<Rgb8>& with, const Image<Rgb8>& without) {
  check(with.size == without.size, "pictures to compare have one size");
  Image<Rgb8> difference(with.size);
  for (std::size_t i = 0; i < difference.pixels.size(); ++i)
    for (int channel = 0; channel < 3; ++channel) {
      const int apart = with.pixels[i][channel] - without.pixels[i][channel];
      difference.pixels[i][channel] = static_cast<std::uint8_t>(std::min((apart + 257) / 2, 255));
    }
  return difference;
}

}  // namespace farshade
