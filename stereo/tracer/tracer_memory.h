/// What a tracer holds in memory, by use: measured (Tracer::memory), and foreseen by its plan.
#pragma once

#include <algorithm>
#include <cstddef>

#include "stereo/plan/scene_plan.h"

namespace farshade {

/// Bytes.
struct TracerMemory {
  std::size_t vertices = 0;  ///< positions and normals
  std::size_t triangles = 0;
  std::size_t facets = 0;  ///< normals and reaches of triangles
  std::size_t hierarchy = 0,
              hierarchy_peak = 0;  ///< all that the traversal's library holds, and held at most
  std::size_t maps = 0;            ///< of lights (light_map.h)

  [[nodiscard]] std::size_t total() const { return vertices + triangles + facets + hierarchy + maps; }
  /// The most at one time: while the hierarchy is built there are no maps yet.
  [[nodiscard]] std::size_t most() const {
    return vertices + triangles + facets + std::max(hierarchy + maps, hierarchy_peak);
  }
};

/// What a tracer of `scene` with `plan` will hold. The hierarchy's share was measured a triangle
/// (Embree 3.13, 1,652 to 344,416 triangles); triangles that a lopsided scene has split (closeup.h) are not
/// foreseen.
[[nodiscard]] TracerMemory foreseen_memory(const Scene& scene, const TracePlan& plan);

}  // namespace farshade
