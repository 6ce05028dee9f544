/// Position grid: stage positions of pixels as integer coordinates of a grid that both sides know.
///
/// Coordinates are rounded to the nearest grid point: the error is at most half a step per axis. The word 0
/// means that the pixel has no surface; the first grid point is 1.
#pragma once

#include <array>
#include <span>

#include "stereo/frame/pixel_plane.h"
#include "stereo/frame/view.h"

namespace farshade {

struct PositionGrid {
  Point<Stage> low;         ///< position of word 1 on each axis
  double step_m = 1;        ///< distance of neighbouring grid points
  std::uint32_t bits = 24;  ///< bits per word
  friend bool operator==(const PositionGrid&, const PositionGrid&) = default;

  [[nodiscard]] std::uint32_t word_bytes() const { return (bits + 7) / 8; }
};

/// Margin on each side of the scene, as a fraction of its longest side: for rounding.
inline constexpr double kGridMargin = 1.0 / 16;

/// A grid with `bits` bits per axis (8 to 24) over the longest side of the scene's bounds at the time of the
/// request (moving_bounds.h), with kGridMargin on each side. The step is equal on all axes.
[[nodiscard]] PositionGrid grid_of(Point<Stage> low, Point<Stage> high, std::uint32_t bits);

/// Words of x, y and z. The planes have the same size and word length, and are 0 in the same pixels.
using PositionPlanes = std::array<PixelPlane, 3>;

/// Writes the positions of the pixel centres of `view` to `planes` and reuses their memory. `distance_m`:
/// metres along -z, row by row, 0 = no surface. Positions outside the grid are written as no surface.
void positions_of(const View& view, std::span<const float> distance_m, const PositionGrid& grid,
                  PositionPlanes& planes);

}  // namespace farshade
