#include "stereo/image/difference.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>

#include "stereo/base/check.h"

namespace farshade {

double mse(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  check(a.size == b.size, "compared pictures have one size");
  if (a.pixels.empty()) return 0;
  std::uint64_t sum = 0;  // integers: the result does not depend on the order of summation
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const glm::ivec3 d = glm::ivec3(a.pixels[i]) - glm::ivec3(b.pixels[i]);
    sum += static_cast<std::uint64_t>(d.x * d.x + d.y * d.y + d.z * d.z);
  }
  return static_cast<double>(sum) / (3.0 * static_cast<double>(a.pixels.size()));
}

double psnr_db(double mse) {
  return 10.0 * std::log10(255.0 * 255.0 / mse);
}

double psnr_db(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  return psnr_db(mse(a, b));
}

Image<Rgb8> difference_x8(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  check(a.size == b.size, "compared pictures have one size");
  Image<Rgb8> shown(a.size);
  std::ranges::transform(a.pixels, b.pixels, shown.pixels.begin(), [](Rgb8 p, Rgb8 q) {
    return Rgb8(glm::min(8 * glm::abs(glm::ivec3(p) - glm::ivec3(q)), glm::ivec3(255)));
  });
  return shown;
}

}  // namespace farshade
