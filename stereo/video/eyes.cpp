#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/video/video.h"

namespace farshade {
namespace {

constexpr Extent even(Extent size) {
  return {size.width + size.width % 2, size.height + size.height % 2};
}

}  // namespace

Extent side_by_side_size(Extent eye) {
  return {2 * even(eye).width, even(eye).height};
}

Image<Rgb8> side_by_side(const PerEye<Image<Rgb8>>& eyes) {
  const Extent eye = eyes[0].size, padded = even(eye);
  check(eyes[1].size == eye && eye.pixels() > 0, "both eyes have one size");
  Image<Rgb8> picture(side_by_side_size(eye));
  for (std::uint32_t y = 0; y < padded.height; ++y)
    for (std::uint32_t x = 0; x < picture.size.width; ++x)
      picture.at(x, y) =
          eyes[x / padded.width].at(std::min(x % padded.width, eye.width - 1), std::min(y, eye.height - 1));
  return picture;
}

PerEye<Image<Rgb8>> two_eyes(const Image<Rgb8>& picture, Extent eye) {
  check(picture.size == side_by_side_size(eye), "the picture is of both eyes side by side");
  PerEye<Image<Rgb8>> eyes{Image<Rgb8>(eye), Image<Rgb8>(eye)};
  for (std::uint32_t i = 0; i < kEyes; ++i)
    for (std::uint32_t y = 0; y < eye.height; ++y)
      std::copy_n(&picture.at(i * even(eye).width, y), eye.width, &eyes[i].at(0, y));
  return eyes;
}

}  // namespace farshade
