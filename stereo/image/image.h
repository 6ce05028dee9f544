/// Pixels in memory: row-major, top row first, without padding.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "stereo/base/extent.h"

namespace farshade {

using Rgb8 = glm::u8vec3;
using Rgba8 = glm::u8vec4;

template <class Pixel>
struct Image {
  Extent size;
  std::vector<Pixel> pixels;

  Image() = default;
  explicit Image(Extent extent, Pixel fill = Pixel{}) : size(extent), pixels(extent.pixels(), fill) {}

  Pixel& at(std::uint32_t x, std::uint32_t y) { return pixels[std::size_t{y} * size.width + x]; }
  const Pixel& at(std::uint32_t x, std::uint32_t y) const { return pixels[std::size_t{y} * size.width + x]; }
  friend bool operator==(const Image&, const Image&) = default;
};

}  // namespace farshade
