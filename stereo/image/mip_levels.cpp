#include "stereo/image/mip_levels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>  // color_space.hpp lacks it
#include <glm/gtc/color_space.hpp>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// Steps of linear light between black and white: 1/20 of the darkest step of 8-bit sRGB.
constexpr int kLightSteps = 65535;

struct LightTables {
  std::array<float, 256> light_of;                    ///< by sRGB value, 0 to 1
  std::array<std::uint8_t, kLightSteps + 1> code_of;  ///< by light, in steps

  LightTables() {
    for (std::size_t code = 0; code < light_of.size(); ++code)
      light_of[code] = glm::convertSRGBToLinear(glm::vec3(static_cast<float>(code) / 255)).r;
    for (std::size_t step = 0; step < code_of.size(); ++step) {
      const float light = static_cast<float>(step) / kLightSteps;
      code_of[step] =
          static_cast<std::uint8_t>(std::lround(255 * glm::convertLinearToSRGB(glm::vec3(light)).r));
    }
  }
};

/// The pixels of one axis that a pixel of the next level covers, and the share of each.
struct Cover {
  std::uint32_t first, count;
  std::array<float, 3> shares;
};

std::vector<Cover> covers_of(std::uint32_t side) {
  std::vector<Cover> covers(std::max(side / 2, 1u));
  const auto whole = static_cast<float>(side);
  const auto count = static_cast<float>(covers.size());
  for (std::uint32_t i = 0; i < covers.size(); ++i) {
    const auto before = static_cast<float>(i);
    if (side == 1)
      covers[i] = {0, 1, {1}};
    else if (side % 2 == 0)
      covers[i] = {2 * i, 2, {0.5f, 0.5f}};
    else
      covers[i] = {2 * i, 3, {(count - before) / whole, count / whole, (before + 1) / whole}};
  }
  return covers;
}

Rgba8 mean(const Rgba8* pixels, std::uint32_t width, const Cover& column, const Cover& row,
           const LightTables& tables) {
  glm::vec4 sum(0);
  for (std::uint32_t y = 0; y < row.count; ++y)
    for (std::uint32_t x = 0; x < column.count; ++x) {
      const Rgba8 p = pixels[std::size_t{row.first + y} * width + column.first + x];
      const auto& light = tables.light_of;
      sum += row.shares[y] * column.shares[x] *
             glm::vec4(light[p.r], light[p.g], light[p.b], static_cast<float>(p.a));
    }
  const auto code = [&](float light) {
    return tables.code_of[static_cast<std::size_t>(std::min(light, 1.f) * kLightSteps + 0.5f)];
  };
  return {code(sum.r), code(sum.g), code(sum.b), static_cast<std::uint8_t>(std::min(sum.a + 0.5f, 255.f))};
}

}  // namespace

std::uint32_t mip_count(Extent size) {
  return static_cast<std::uint32_t>(std::bit_width(std::max(size.width, size.height)));
}

Extent next_mip(Extent size) {
  return {std::max(size.width / 2, 1u), std::max(size.height / 2, 1u)};
}

std::size_t mip_pixels(Extent size) {
  std::size_t pixels = size.pixels();
  while (size != Extent{1, 1}) pixels += (size = next_mip(size)).pixels();
  return pixels;
}

std::vector<Rgba8> smaller_levels(const Image<Rgba8>& largest) {
  check(largest.size.width > 0 && largest.size.height > 0, "a texture has pixels");
  static const LightTables tables;
  std::vector<Rgba8> levels(mip_pixels(largest.size) - largest.size.pixels());
  const Rgba8* from = largest.pixels.data();
  Rgba8* to = levels.data();
  for (Extent size = largest.size; size != Extent{1, 1}; size = next_mip(size)) {
    const std::vector<Cover> columns = covers_of(size.width), rows = covers_of(size.height);
    Rgba8* const level = to;
    for (const Cover& row : rows)
      for (const Cover& column : columns) *to++ = mean(from, size.width, column, row, tables);
    from = level;
  }
  return levels;
}

}  // namespace farshade
