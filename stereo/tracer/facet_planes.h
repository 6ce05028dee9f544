/// FacetPlanes: the planes in which the fixed triangles lie, each with room for all of its triangles and for
/// what the traversal's rounding may see of them.
///
/// Triangles that follow each other in one plane share it, so that a wall is one thing and not many.
#pragma once

#include <cstdint>
#include <vector>

#include "stereo/tracer/surface_model.h"

namespace farshade {

inline constexpr std::uint32_t kNoPlane = ~0u;  ///< of triangles too thin to have one

/// low <= dot(normal, x) <= high for every point x of its triangles; anchor-relative metres.
struct FacetPlane {
  glm::vec3 normal{0.0f};
  float low = 0, high = 0;
  float reach = 0;  ///< Facet::reach, the largest
  /// Nearer to the slab than this, a ray that does not meet a triangle may yet be taken to meet it.
  float doubt = 0;
};

struct FacetPlanes {
  std::vector<FacetPlane> planes;
  std::vector<std::uint32_t> of_triangle;  ///< fixed triangles only: into planes, or kNoPlane
  float reach = 0;                         ///< largest of all
};

[[nodiscard]] FacetPlanes planes_of(const SurfaceModel& model);

}  // namespace farshade
