#include "stereo/lod/levels.h"

#include <meshoptimizer.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/lod/level_error.h"

namespace farshade {
namespace {

/// Each level shall have this share of the triangles of the one before. The chain ends when a level has more
/// than kLeastGain of them, or few enough, or an error so great that the mesh's shape or shading is lost.
constexpr double kShare = 0.5, kLeastGain = 0.85, kLostShape = 0.1, kLostNormals_rad = 0.6;
constexpr std::size_t kFewTriangles = 16;

}  // namespace

MeshLevels make_levels(const Mesh& mesh) {
  MeshLevels result;
  if (mesh.triangles.size() <= kFewTriangles || mesh.deformable) return result;
  const WeldedMesh welded = weld(mesh);
  if (welded.triangles.size() <= kFewTriangles) return result;
  std::vector<glm::vec3> positions;
  for (const std::uint32_t vertex : welded.vertices) positions.push_back(mesh.positions[vertex]);
  const float scale = meshopt_simplifyScale(&positions[0].x, positions.size(), sizeof(glm::vec3));
  LevelError error(mesh, welded, positions);
  std::vector<glm::uvec3> finer = welded.triangles;
  float bound = 0;
  while (finer.size() > kFewTriangles) {
    const auto target = static_cast<std::size_t>(static_cast<double>(finer.size()) * kShare) * 3;
    std::vector<glm::uvec3> coarser(finer.size());
    float estimate = 0;
    const std::size_t indices =
        meshopt_simplify(&coarser[0].x, &finer[0].x, finer.size() * 3, &positions[0].x, positions.size(),
                         sizeof(glm::vec3), target, 1.0f, 0, &estimate);
    coarser.resize(indices / 3);
    if (coarser.empty() ||
        static_cast<double>(coarser.size()) > kLeastGain * static_cast<double>(finer.size()))
      break;
    const MeasuredError measured = error.measure(coarser, estimate * scale);
    bound = std::max(bound, measured.distance);
    if (!(bound < kLostShape * scale) || measured.normal_rad > kLostNormals_rad) break;
    meshopt_optimizeVertexCache(&coarser[0].x, &coarser[0].x, indices, positions.size());
    result.levels.push_back(
        {narrow<std::uint32_t>(result.triangles.size()), narrow<std::uint32_t>(coarser.size()), bound});
    for (const glm::uvec3& t : coarser)
      result.triangles.emplace_back(welded.vertices[t.x], welded.vertices[t.y], welded.vertices[t.z]);
    finer = std::move(coarser);
  }
  return result;
}

SceneLevels make_levels(const Scene& scene) {
  SceneLevels levels(scene.meshes.size());
  tbb::parallel_for(std::size_t{0}, levels.size(),
                    [&](std::size_t mesh) { levels[mesh] = make_levels(scene.meshes[mesh]); });
  return levels;
}

}  // namespace farshade
