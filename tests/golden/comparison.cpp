#include "tests/golden/comparison.h"

#include <algorithm>
#include <glm/common.hpp>

#include "stereo/base/check.h"
#include "stereo/image/difference.h"

namespace farshade {

Distance distance(const Image<Rgb8>& picture, const Image<Rgb8>& golden) {
  check(picture.size == golden.size, "pictures of one size are compared");
  std::size_t differing = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const glm::ivec3 apart = glm::abs(glm::ivec3(picture.pixels[i]) - glm::ivec3(golden.pixels[i]));
    differing += std::max({apart.x, apart.y, apart.z}) > 2 ? 1 : 0;
  }
  return {psnr_db(picture, golden),
          static_cast<double>(differing) / static_cast<double>(picture.pixels.size())};
}

}  // namespace farshade
