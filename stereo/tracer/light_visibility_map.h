/// LightVisibilityMap: the occluders around one light, by direction. It proves that points are lit, without a
/// ray.
///
/// The directions from the light are divided into cells. Each cell holds every fixed triangle that touches
/// it: its plane, or else its least depth, widened by all rounding errors. The light is visible from a point
/// if, for each plane in the point's cell, the point lies on the light's side of the plane or nearer than the
/// plane's triangles, and if the point lies nearer than all other occluders of the cell. This is conservative
/// like shaft culling (E. Haines and J. Wallace, "Shaft Culling for Efficient Ray-Traced Radiosity", 1991)
/// over the cells of a light buffer (E. Haines and D. Greenberg, "The Light Buffer: A Shadow-Testing
/// Accelerator", 1986), which lists the possible occluders of each cell. Moving meshes are entered again, by
/// their bounding boxes, whenever they are placed.
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

  /// The normal points to the light: points with dot(normal, x) - offset >= doubt are on the light's side.
  struct Plane {
    float nx = 0, ny = 0, nz = 0, offset = 0, doubt = 0;
  };

  /// Depths are in metres: from a point or spot light along the face's axis, or along a directional light's
  /// direction.
  struct Cell {
    float rest = kFar;    ///< least depth of the fixed triangles whose planes are not in `plane`
    float moving = kFar;  ///< least depth of the moving meshes; 0 where one may surround the light
    std::array<std::uint32_t, kPlanes> plane{};  ///< into planes(); as many as have a finite `from`
    std::array<float, kPlanes> from{kFar, kFar,
                                    kFar};  ///< least depth of that plane's triangles in this cell
  };

  /// Enters `model` with its current placements.
  LightVisibilityMap(const ShadowLight& light, const FacetPlanes& planes, const SurfaceModel& model);

  /// Enters the moving meshes where the model has placed them now.
  void place(const SurfaceModel& model);

  /// Whether the map holds for `light`: same kind, position and direction.
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
  std::vector<std::uint32_t> moving_cells_;  ///< cells with a finite `moving`
};

}  // namespace farshade
