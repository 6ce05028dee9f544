/// Colours that the overlays and their legends share.
#pragma once

#include <vector>

#include "stereo/base/clock.h"
#include "stereo/image/image.h"

namespace farshade::overlay {

inline constexpr Rgb8 kUnknownColor(255, 140, 0), kStaleColor(255, 40, 40), kThisEyeColor(60, 220, 90),
    kOtherEyeColor(60, 210, 230), kNeighbourColor(240, 230, 60), kCubeMaskColor(235, 120, 220),
    kRaysColor(235, 235, 235), kOutlineColor(0, 255, 170), kNotTracedColor(110, 20, 30);

/// Multiplies a colour by a factor, which is clamped to 0..1.
[[nodiscard]] Rgb8 scaled(Rgb8 color, float factor);

/// Grey for a visibility or a share of visible lights within 0..1. The grey of 0 differs from black, which
/// means no geometry.
[[nodiscard]] Rgb8 grey(float share);

/// The colour map viridis at `share`, which is clamped to 0..1.
[[nodiscard]] Rgb8 ramp(float share);

/// part / whole, and 0 if `whole` is 0.
[[nodiscard]] float share_of(std::size_t part, std::size_t whole);

/// Colour of the mask that is `mask` masks older than the newest.
[[nodiscard]] Rgb8 older_color(std::size_t mask);

[[nodiscard]] Rgb8 age_color(Duration age);

/// Colour of a pixel for which this share of the lights is unknown, above 0.
[[nodiscard]] Rgb8 unknown_color(float share);

/// The luma (Rec. 709) as grey, times 0.45, so that colours stand out against it.
[[nodiscard]] Rgb8 dimmed(Rgb8 color);

/// Colour of a pixel with outdated visibility.
[[nodiscard]] Rgb8 stale_tint(Rgb8 color);

/// Colour of a traced pixel that is not shown.
[[nodiscard]] Rgb8 guard_band_tint(Rgb8 color);
/// Of a source whose bits were reprojected, not asked for: paler.
[[nodiscard]] Rgb8 reprojected_tint(Rgb8 color);

/// The results of `get` for 0, 1, .. count - 1. A picture computes its colours once, not for each pixel.
template <class Get>
auto lookup_table(std::size_t count, const Get& get) {
  std::vector<decltype(get(count))> results;
  for (std::size_t i = 0; i < count; ++i) results.push_back(get(i));
  return results;
}

}  // namespace farshade::overlay
