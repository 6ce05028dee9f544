#include "stereo/edge_rays/caster_triangles.h"

#include "stereo/scene/scene_state.h"

namespace farshade {

CasterTriangles caster_triangles(const Scene& scene, const DrawPlan& plan) {
  CasterTriangles result{
      .origin = {(scene.bounds.low + scene.bounds.high) * 0.5}, .corners = {}, .has_holes = {}};
  const std::vector<Affine<Stage, Object>> places = places_at_start(scene);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (!instance.casts || plan.moves[i] || is_singular(glm::dmat3(places[i].matrix))) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const glm::uvec3& t : mesh.triangles) {
      std::array<glm::vec3, 3> corners;
      for (int c = 0; c < 3; ++c) {
        const Point<Object> corner{glm::dvec3(mesh.positions[t[c]])};
        corners[static_cast<std::size_t>(c)] = glm::vec3(places[i](corner).v - result.origin.v);
      }
      result.corners.push_back(corners);
      result.has_holes.push_back(plan.surfaces[instance.mesh].alpha_test);
    }
  }
  return result;
}

}  // namespace farshade
