/// ViewScale: the width and height of requested views, in eighths of the width and height of the displayed
/// views. A server on a slow path asks its client for smaller views.
#pragma once

#include <compare>
#include <cstdint>

namespace farshade {

struct ViewScale {
  static constexpr std::uint32_t kFull_eighths = 8;

  std::uint32_t eighths = kFull_eighths;  ///< kLeastViewScale to kFullViewScale

  friend auto operator<=>(ViewScale, ViewScale) = default;
};

inline constexpr ViewScale kFullViewScale{ViewScale::kFull_eighths}, kLeastViewScale{1};

[[nodiscard]] constexpr bool is_valid(ViewScale scale) {
  return scale >= kLeastViewScale && scale <= kFullViewScale;
}

/// `scale` as a factor of a length: 1 is full size.
[[nodiscard]] constexpr double factor_of(ViewScale scale) {
  return static_cast<double>(scale.eighths) / ViewScale::kFull_eighths;
}

/// A width or height at `scale`, rounded to the nearest pixel.
[[nodiscard]] constexpr std::uint32_t scaled_px(std::uint32_t full_px, ViewScale scale) {
  return (full_px * scale.eighths + ViewScale::kFull_eighths / 2) / ViewScale::kFull_eighths;
}

}  // namespace farshade
