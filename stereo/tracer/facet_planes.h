/// FacetPlanes: the planes of the fixed triangles. Each plane is a slab that contains all of its triangles.
///
/// Consecutive triangles in one plane share it, so that a wall is one plane and not many.
#pragma once

#include <cstdint>
#include <vector>

#include "stereo/tracer/surface_model.h"

namespace farshade {

inline constexpr std::uint32_t kNoPlane = ~0u;  ///< of triangles that are too thin to have a plane

/// low <= dot(normal, x) <= high for every point x of its triangles, in anchor space.
struct FacetPlane {
  glm::vec3 normal{0.0f};
  float low = 0, high = 0;
  float reach = 0;  ///< largest Facet::reach of its triangles
  /// Metres. If a ray misses a triangle of this plane but comes nearer to the slab than this, rounding in the
  /// traversal may still report a hit.
  float doubt = 0;
};

struct FacetPlanes {
  std::vector<FacetPlane> planes;
  std::vector<std::uint32_t> of_triangle;  ///< for each fixed triangle: an index into planes, or kNoPlane
  float reach = 0;                         ///< the largest of all
};

[[nodiscard]] FacetPlanes planes_of(const SurfaceModel& model);

}  // namespace farshade
