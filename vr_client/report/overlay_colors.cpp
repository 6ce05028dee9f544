#include "vr_client/report/overlay_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "vr_client/report/overlays.h"

namespace farshade::overlay {
namespace {

constexpr Rgb8 kGuardBandColor(150, 60, 255);
constexpr float kLowestGrey = 40;

Rgb8 mixed(Rgb8 a, Rgb8 b, float share_of_b) {
  return Rgb8(glm::round(glm::mix(glm::vec3(a), glm::vec3(b), share_of_b)));
}

}  // namespace

Rgb8 scaled(Rgb8 color, float factor) {
  return Rgb8(glm::vec3(color) * std::clamp(factor, 0.0f, 1.0f));
}

Rgb8 grey(float share) {
  return Rgb8(static_cast<std::uint8_t>(std::lround(kLowestGrey + (255 - kLowestGrey) * share)));
}

/// Six equidistant samples of viridis, with linear interpolation of sRGB values between them.
Rgb8 ramp(float share) {
  constexpr std::array<glm::vec3, 6> steps{
      {{68, 1, 84}, {65, 68, 135}, {42, 120, 142}, {34, 168, 132}, {122, 209, 81}, {253, 231, 37}}};
  const float place = std::clamp(share, 0.0f, 1.0f) * (steps.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), steps.size() - 2);
  return Rgb8(glm::round(glm::mix(steps[below], steps[below + 1], place - static_cast<float>(below))));
}

float share_of(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0f : static_cast<float>(part) / static_cast<float>(whole);
}

Rgb8 older_color(std::size_t mask) {
  return {static_cast<std::uint8_t>(70 + 40 * mask), 90, 255};
}

Rgb8 age_color(Duration age) {
  return ramp(static_cast<float>(seconds_of(age) / seconds_of(kOldestDrawn)));
}

Rgb8 unknown_color(float share) {
  return scaled(kUnknownColor, 0.4f + 0.6f * share);
}

Rgb8 dimmed(Rgb8 color) {
  return Rgb8(static_cast<std::uint8_t>((25 * color.r + 82 * color.g + 8 * color.b) >> 8));
}

Rgb8 stale_tint(Rgb8 color) {
  return mixed(color, kStaleColor, 0.5f);
}

Rgb8 reprojected_tint(Rgb8 color) {
  return Rgb8((glm::uvec3(color) + 255u) / 2u);
}

Rgb8 guard_band_tint(Rgb8 color) {
  return mixed(color, kGuardBandColor, 0.5f);
}

}  // namespace farshade::overlay
