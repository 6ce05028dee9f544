/// CasterTriangles: the triangles that cast shadows and never move, in full detail, for the client's own
/// shadow rays (light_buffer.h).
#pragma once

#include <array>
#include <vector>

#include "stereo/plan/scene_plan.h"

namespace farshade {

struct CasterTriangles {
  Point<Stage> origin;  ///< the centre of the scene's bounds; the corners are relative to it
  std::vector<std::array<glm::vec3, 3>> corners;
  std::vector<bool> has_holes;
};

/// `moves`: one per instance (DrawPlan::moves).
[[nodiscard]] CasterTriangles caster_triangles(const Scene& scene, const DrawPlan& plan);

}  // namespace farshade
