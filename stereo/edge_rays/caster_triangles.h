/// CasterTriangles: the triangles that cast shadows and never move, in full detail, for the client's own
/// shadow rays (light_buffer.h).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "stereo/plan/scene_plan.h"

namespace farshade {

/// The alpha of a triangle with holes: interpolated between its corners, times its texture's. A point with
/// less than `cutoff` is a hole (stereo/tracer/hole_test.h).
struct TriangleAlpha {
  float cutoff = 0;
  std::array<float, 3> at_corners{};                    ///< the material's factor times vertex colour
  std::optional<std::uint32_t> texture = std::nullopt;  ///< into Scene::textures
  std::array<glm::vec2, 3> uvs{};                       ///< of the texture
};

struct CasterTriangles {
  Point<Stage> origin;  ///< the centre of the scene's bounds; the corners are relative to it
  std::vector<std::array<glm::vec3, 3>> corners;
  std::vector<bool> has_holes;
  std::vector<TriangleAlpha> alphas{};  ///< of the triangles with holes, in their order
};

/// `moves`: one per instance (DrawPlan::moves).
[[nodiscard]] CasterTriangles caster_triangles(const Scene& scene, const DrawPlan& plan);

}  // namespace farshade
