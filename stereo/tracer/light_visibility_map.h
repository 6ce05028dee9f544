/// LightVisibilityMap: what stands first around one light, cell by cell of its directions, so that what
/// nothing can shadow is known to be lit without a ray.
///
/// Every fixed triangle that touches a cell is in it, if not by its plane then by its least depth, and by no
/// less than all of its rounding: a point with all of its cell's planes behind it, as the light sees it, or
/// farther than itself, and nearer than the rest, is in sight of the light. Conservative as the shafts of E.
/// Haines and J. Wallace, "Shaft Culling for Efficient Ray-Traced Radiosity", 1991, over the cells of a light
/// buffer (E. Haines and D. Greenberg, "The Light Buffer: A Shadow-Testing Accelerator", 1986), which lists
/// for each of them what may occlude. What moves is entered anew, as boxes, whenever it is placed.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "stereo/tracer/cell_cover.h"
#include "stereo/tracer/facet_planes.h"
#include "stereo/tracer/shadow_light.h"

namespace farshade {

class LightVisibilityMap {
 public:
  static constexpr int kPlanes = 3;
  static constexpr int kSide = 32;  ///< cells along a side of a face

  /// Oriented to the light: points with dot(normal, x) - offset >= doubt are on its side.
  struct Plane {
    float nx = 0, ny = 0, nz = 0, offset = 0, doubt = 0;
  };

  /// Depths are metres: along the face's axis from a point or spot light, along a directional light's way.
  struct Cell {
    float rest = kFar;    ///< all that `plane` has no room for is at least as deep
    float moving = kFar;  ///< all that moves is at least as deep
    std::array<std::uint32_t, kPlanes> plane{};
    std::array<float, kPlanes> from{kFar, kFar, kFar};  ///< least depth of that plane's triangles here
  };

  /// `model` as placed.
  LightVisibilityMap(const ShadowLight& light, const FacetPlanes& planes, const SurfaceModel& model);

  /// Takes over the model's placements.
  void place(const SurfaceModel& model);

  /// Whether it is of a light that stands where `light` does.
  [[nodiscard]] bool is_of(const ShadowLight& light) const;

  [[nodiscard]] const CellFrame& frame() const { return frame_; }
  [[nodiscard]] std::span<const Cell> cells() const { return cells_; }
  [[nodiscard]] std::span<const Plane> planes() const { return planes_; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  void enter_fixed(const FacetPlanes& planes, const SurfaceModel& model);
  void drop_unused_planes();

  ShadowLight light_;
  CellFrame frame_;
  std::vector<Cell> cells_;
  std::vector<Plane> planes_;
  std::vector<std::uint32_t> moving_cells_;  ///< with something that moves in them
};

}  // namespace farshade
