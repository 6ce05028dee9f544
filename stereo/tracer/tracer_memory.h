/// What a tracer holds in memory, by use.
#pragma once

#include <cstddef>

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
};

}  // namespace farshade
