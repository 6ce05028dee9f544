#include "stereo/edge_rays/caster_triangles.h"

#include <limits>

#include "stereo/scene/scene_state.h"

namespace farshade {
namespace {

TriangleAlpha alpha_of(const Scene& scene, const Mesh& mesh, const glm::uvec3& triangle) {
  const Material& material = scene.materials[mesh.material];
  TriangleAlpha result{.cutoff = material.alpha_cutoff.value_or(-std::numeric_limits<float>::infinity())};
  result.at_corners.fill(material.base_color.a);
  if (!mesh.uvs.empty()) result.texture = material.texture;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t vertex = triangle[static_cast<int>(corner)];
    if (result.texture) result.uvs[corner] = mesh.uvs[vertex];
    if (!mesh.colors.empty()) result.at_corners[corner] *= static_cast<float>(mesh.colors[vertex].a) / 255.0f;
  }
  return result;
}

}  // namespace

CasterTriangles caster_triangles(const Scene& scene, const DrawPlan& plan) {
  CasterTriangles result{
      .origin = {(scene.bounds.low + scene.bounds.high) * 0.5}, .corners = {}, .has_holes = {}};
  const std::vector<Affine<Stage, Object>> places = places_at_start(scene);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (!instance.casts || plan.moves[i] || is_singular(glm::dmat3(places[i].matrix))) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    const bool has_holes = plan.surfaces[instance.mesh].alpha_test;
    for (const glm::uvec3& t : mesh.triangles) {
      std::array<glm::vec3, 3> corners;
      for (int c = 0; c < 3; ++c) {
        const Point<Object> corner{glm::dvec3(mesh.positions[t[c]])};
        corners[static_cast<std::size_t>(c)] = glm::vec3(places[i](corner).v - result.origin.v);
      }
      result.corners.push_back(corners);
      result.has_holes.push_back(has_holes);
      if (has_holes) result.alphas.push_back(alpha_of(scene, mesh, t));
    }
  }
  return result;
}

}  // namespace farshade
