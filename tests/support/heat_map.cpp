#include "tests/support/heat_map.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/common.hpp>

namespace farshade {
namespace {

constexpr std::array<glm::vec3, 6> kSteps{
    {{0, 0, 4}, {59, 15, 112}, {140, 41, 129}, {222, 73, 104}, {254, 159, 109}, {252, 253, 191}}};

Rgb8 colour_of(float error) {
  const float place = error > 0 ? std::min(error, 1.0f) * (kSteps.size() - 1) : 0.0f;
  const std::size_t below = std::min(static_cast<std::size_t>(place), kSteps.size() - 2);
  return Rgb8(glm::round(glm::mix(kSteps[below], kSteps[below + 1], place - static_cast<float>(below))));
}

}  // namespace

Image<Rgb8> heat_map(const Image<float>& error) {
  Image<Rgb8> map(error.size);
  std::ranges::transform(error.pixels, map.pixels.begin(), colour_of);
  return map;
}

}  // namespace farshade
