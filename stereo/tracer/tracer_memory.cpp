#include "stereo/tracer/tracer_memory.h"

#include "stereo/tracer/surface_model.h"

namespace farshade {
namespace {

/// Per triangle.
constexpr std::size_t kHierarchy_bytes = 67;
/// In addition, per fixed triangle, while the structure over all of them is built: by Embree 4 or 3.
#if __has_include(<embree4/rtcore.h>)
constexpr std::size_t kBuilding_bytes = 30;
#else
constexpr std::size_t kBuilding_bytes = 43;
#endif

}  // namespace

TracerMemory estimated_memory(const Scene& scene, const TracePlan& plan) {
  TracerMemory memory;
  std::size_t fixed = 0, triangles = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    memory.vertices += mesh.positions.size() * 2 * sizeof(glm::vec3);
    triangles += mesh.triangles.size();
    fixed += plan.moves[i] ? 0 : mesh.triangles.size();
  }
  memory.triangles = triangles * sizeof(glm::uvec3);
  memory.facets = triangles * sizeof(Facet);
  memory.hierarchy = triangles * kHierarchy_bytes;
  memory.hierarchy_peak = memory.hierarchy + fixed * kBuilding_bytes;
  return memory;
}

}  // namespace farshade
