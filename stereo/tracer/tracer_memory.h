/// The memory of a tracer by use: measured (Tracer::memory), and predicted from its plan.
#pragma once

#include <algorithm>
#include <cstddef>

#include "stereo/plan/scene_plan.h"

namespace farshade {

/// Bytes.
struct TracerMemory {
  std::size_t vertices = 0;  ///< positions and normals
  std::size_t triangles = 0;
  std::size_t facets = 0;          ///< normals and reaches of triangles
  std::size_t hierarchy = 0;       ///< acceleration structure: all memory that Embree holds
  std::size_t hierarchy_peak = 0;  ///< the most that Embree ever held

  [[nodiscard]] std::size_t total() const { return vertices + triangles + facets + hierarchy; }
  /// The most at one time.
  [[nodiscard]] std::size_t most() const {
    return vertices + triangles + facets + std::max(hierarchy, hierarchy_peak);
  }
};

/// What a tracer of `scene` with `plan` will hold. The hierarchy's bytes per triangle were measured
/// (Embree 3.13, 1,652 to 344,416 triangles). Triangles that a lopsided scene has split (closeup.h) are not
/// predicted.
[[nodiscard]] TracerMemory estimated_memory(const Scene& scene, const TracePlan& plan);

}  // namespace farshade
