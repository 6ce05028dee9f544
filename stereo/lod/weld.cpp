#include "stereo/lod/weld.h"

#include <meshoptimizer.h>

#include <cmath>

namespace farshade {
namespace {

constexpr auto kNone = static_cast<std::uint32_t>(-1);

/// For each vertex a number that it shares with the vertices that have all its attributes but the normal;
/// kNone for vertices that no triangle uses.
std::vector<std::uint32_t> without_normals(const Mesh& mesh) {
  std::vector<meshopt_Stream> streams{{mesh.positions.data(), sizeof(glm::vec3), sizeof(glm::vec3)}};
  if (!mesh.uvs.empty()) streams.push_back({mesh.uvs.data(), sizeof(glm::vec2), sizeof(glm::vec2)});
  if (!mesh.colors.empty()) streams.push_back({mesh.colors.data(), sizeof(glm::u8vec4), sizeof(glm::u8vec4)});
  std::vector<std::uint32_t> shared(mesh.positions.size());
  meshopt_generateVertexRemapMulti(shared.data(), &mesh.triangles[0].x, mesh.triangles.size() * 3,
                                   mesh.positions.size(), streams.data(), streams.size());
  return shared;
}

/// Groups of vertices that become one. A group is named by its first vertex.
struct Groups {
  std::vector<std::uint32_t> of_vertex;  ///< kNone if no triangle uses the vertex
  std::vector<glm::vec3> normal_sum;     ///< at the group's first vertex
};

Groups group_by_normal(const Mesh& mesh, const std::vector<std::uint32_t>& shared) {
  const std::size_t count = mesh.positions.size();
  const auto least_cos = static_cast<float>(std::cos(kSmooth_rad));
  // The groups of one shared number form a list, the newest first.
  std::vector<std::uint32_t> newest(count, kNone), next(count, kNone);
  Groups groups{std::vector<std::uint32_t>(count, kNone), std::vector<glm::vec3>(count, glm::vec3(0))};
  for (std::uint32_t i = 0; i < count; ++i) {
    if (shared[i] == kNone) continue;
    const auto fits = [&](std::uint32_t group) {
      const glm::vec3& sum = groups.normal_sum[group];
      return glm::dot(sum, mesh.normals[i]) >= least_cos * glm::length(sum);
    };
    std::uint32_t group = newest[shared[i]];
    while (group != kNone && !fits(group)) group = next[group];
    if (group == kNone) {
      group = i;
      next[group] = newest[shared[i]];
      newest[shared[i]] = group;
    }
    groups.of_vertex[i] = group;
    groups.normal_sum[group] += mesh.normals[i];
  }
  return groups;
}

/// For each group, the vertex whose normal is closest to the group's mean.
std::vector<std::uint32_t> representatives(const Mesh& mesh, const Groups& groups) {
  std::vector<std::uint32_t> best(groups.of_vertex.size(), kNone);
  std::vector<float> closeness(best.size());
  for (std::uint32_t i = 0; i < best.size(); ++i) {
    const std::uint32_t group = groups.of_vertex[i];
    if (group == kNone) continue;
    const float close = glm::dot(groups.normal_sum[group], mesh.normals[i]);
    if (best[group] != kNone && close <= closeness[group]) continue;
    best[group] = i;
    closeness[group] = close;
  }
  return best;
}

std::vector<bool> seams(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
  std::vector<glm::vec3> positions;
  for (const std::uint32_t vertex : vertices) positions.push_back(mesh.positions[vertex]);
  std::vector<std::uint32_t> place(positions.size());
  meshopt_generateVertexRemap(place.data(), nullptr, positions.size(), positions.data(), positions.size(),
                              sizeof(glm::vec3));
  std::vector<std::uint32_t> there(positions.size(), 0);
  for (const std::uint32_t p : place) ++there[p];
  std::vector<bool> on_seam;
  for (const std::uint32_t p : place) on_seam.push_back(there[p] > 1);
  return on_seam;
}

}  // namespace

WeldedMesh weld(const Mesh& mesh) {
  WeldedMesh welded;
  if (mesh.triangles.empty()) return welded;
  const Groups groups = group_by_normal(mesh, without_normals(mesh));
  const std::vector<std::uint32_t> vertex_of = representatives(mesh, groups);
  std::vector<std::uint32_t> place(vertex_of.size(), kNone);
  const auto place_of = [&](std::uint32_t vertex) {
    std::uint32_t& at = place[groups.of_vertex[vertex]];
    if (at == kNone) {
      at = static_cast<std::uint32_t>(welded.vertices.size());
      welded.vertices.push_back(vertex_of[groups.of_vertex[vertex]]);
    }
    return at;
  };
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::uvec3 joined(place_of(t.x), place_of(t.y), place_of(t.z));
    if (joined.x != joined.y && joined.y != joined.z && joined.z != joined.x)
      welded.triangles.push_back(joined);
  }
  welded.on_seam = seams(mesh, welded.vertices);
  return welded;
}

}  // namespace farshade
