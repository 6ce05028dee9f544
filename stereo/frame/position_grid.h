/// Position grid: where a view's pixels lie in the stage, as whole numbers of a grid that both sides know.
///
/// Coordinates are rounded to the nearest grid point, so that a position is wrong by at most half a step an
/// axis. The word 0 says that no surface covers the pixel; the first grid point is 1.
#pragma once

#include <array>
#include <span>

#include "stereo/frame/pixel_plane.h"
#include "stereo/frame/view.h"

namespace farshade {

struct PositionGrid {
  Point<Stage> low;         ///< of word 1, on each axis
  double step_m = 1;        ///< between neighbours
  std::uint32_t bits = 24;  ///< of a word
  friend bool operator==(const PositionGrid&, const PositionGrid&) = default;

  [[nodiscard]] std::uint32_t word_bytes() const { return (bits + 7) / 8; }
  /// `word` is not 0.
  [[nodiscard]] double offset_m(std::uint32_t word) const { return (word - 1.0) * step_m; }
};

/// Kept free on each side of the scene, a share of its longest side: for rounding, and for what moves a
/// little out of the bounds that the scene has at time 0.
inline constexpr double kGridMargin = 1.0 / 16;

/// A grid of `bits` bits an axis (8 to 24) over the longest side of the scene's bounds, grown by kGridMargin
/// on each side. Steps are equal on all axes.
[[nodiscard]] PositionGrid grid_of(Point<Stage> low, Point<Stage> high, std::uint32_t bits);

/// Words of x, y and z: of one size and word length, 0 in the same pixels.
using PositionPlanes = std::array<PixelPlane, 3>;

/// Positions of the pixel centres of `view` into `planes`, whose memory is reused. `distance_m`: metres along
/// -z, row by row, 0 = not covered. What lies outside of the grid is told as not covered.
void positions_of(const View& view, std::span<const float> distance_m, const PositionGrid& grid,
                  PositionPlanes& planes);

}  // namespace farshade
