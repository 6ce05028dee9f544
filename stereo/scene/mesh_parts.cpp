#include "stereo/scene/mesh_parts.h"

#include <meshoptimizer.h>

#include <glm/matrix.hpp>
#include <span>

namespace farshade {
namespace {

template <class T>
std::vector<T> picked(const std::vector<T>& values, const std::vector<std::uint32_t>& vertices) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(vertices.size());
  for (const std::uint32_t vertex : vertices) result.push_back(values[vertex]);
  return result;
}

/// The mesh with `vertices` only.
Mesh with(const Mesh& mesh, const std::vector<std::uint32_t>& vertices, std::vector<glm::uvec3> triangles) {
  Mesh part{mesh.name,
            mesh.material,
            picked(mesh.positions, vertices),
            picked(mesh.normals, vertices),
            picked(mesh.uvs, vertices),
            picked(mesh.colors, vertices),
            std::move(triangles)};
  const Deformable& from = *mesh.deformable;
  Deformable to{.positions = picked(from.positions, vertices),
                .normals = picked(from.normals, vertices),
                .influences = picked(from.influences, vertices)};
  for (const Deformable::Target& target : from.targets)
    to.targets.push_back({picked(target.positions, vertices), picked(target.normals, vertices)});
  part.deformable = std::move(to);
  return part;
}

/// Whether the skin mirrors what is at a vertex.
bool is_mirrored(const Deformable& deformable, const RigPose& pose, std::uint32_t vertex) {
  if (deformable.influences.empty()) return false;
  const auto& [joints, weights] = deformable.influences[vertex];
  glm::mat4 blended(0.0f);
  for (int i = 0; i < 4; ++i) blended += pose.object_from_bind[joints[i]] * weights[i];
  return glm::determinant(glm::mat3(blended)) < 0;
}

/// Exchanges two corners. A flat triangle keeps its indices and exchanges its vertices.
void turn_over(Mesh& mesh, glm::uvec3& t) {
  if (!mesh.deformable->normals.empty()) return std::swap(t.y, t.z);
  const auto exchange = [&](auto& stream) {
    if (!stream.empty()) std::swap(stream[t.y], stream[t.z]);
  };
  exchange(mesh.uvs), exchange(mesh.colors);
  exchange(mesh.deformable->positions), exchange(mesh.deformable->influences);
  for (Deformable::Target& target : mesh.deformable->targets) exchange(target.positions);
}

}  // namespace

void pose_at_start(const RigPose& pose, Mesh& mesh) {
  for (glm::uvec3& t : mesh.triangles)
    if (is_mirrored(*mesh.deformable, pose, t.x)) turn_over(mesh, t);
  Deformation(*mesh.deformable, pose).write(mesh.positions, mesh.normals);
}

std::vector<Mesh> parts_of(Mesh mesh) {
  std::vector<Mesh> parts;
  if (mesh.triangles.size() <= kPartTriangles) {
    parts.push_back(std::move(mesh));
    return parts;
  }
  std::vector<glm::uvec3> sorted(mesh.triangles.size());
  meshopt_spatialSortTriangles(&sorted[0].x, &mesh.triangles[0].x, sorted.size() * 3,
                               &mesh.deformable->positions[0].x, mesh.positions.size(), sizeof(glm::vec3));
  constexpr std::uint32_t kNone = ~0u;
  std::vector<std::uint32_t> number(mesh.positions.size(), kNone);
  for (std::span<glm::uvec3> rest(sorted); !rest.empty();) {
    const std::span<glm::uvec3> triangles = rest.first(std::min(kPartTriangles, rest.size()));
    std::vector<std::uint32_t> vertices;
    for (glm::uvec3& t : triangles)
      for (glm::length_t corner = 0; corner < 3; ++corner) {
        std::uint32_t& own = number[t[corner]];
        if (own == kNone) {
          own = static_cast<std::uint32_t>(vertices.size());
          vertices.push_back(t[corner]);
        }
        t[corner] = own;
      }
    for (const std::uint32_t vertex : vertices) number[vertex] = kNone;
    parts.push_back(with(mesh, vertices, {triangles.begin(), triangles.end()}));
    rest = rest.subspan(triangles.size());
  }
  return parts;
}

}  // namespace farshade
