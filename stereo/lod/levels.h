/// Levels of detail: coarser triangle lists for each mesh, over the vertices that the mesh has. Each level
/// has a bound on its error, so that a frame can draw a mesh with the fewest triangles whose error stays
/// below a fraction of a pixel (level_choice.h). The triangles are chosen by meshopt_simplify (M. Garland, P.
/// Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997); the error is measured
/// afterwards, because the quadrics only estimate its mean.
#pragma once

#include "stereo/scene/scene.h"

namespace farshade {

struct DetailLevel {
  std::uint32_t first = 0, count = 0;  ///< triangles in MeshLevels::triangles
  /// Object space units. Every sampled point of either surface has a point of the other one within this
  /// distance. An attribute that differs counts as the distance over which it changes as much on the full
  /// mesh.
  float error = 0;
};

/// The levels of a mesh besides the mesh itself. Each has fewer triangles and a greater error than the one
/// before.
struct MeshLevels {
  std::vector<glm::uvec3> triangles;  ///< vertex indices into the mesh, level after level
  std::vector<DetailLevel> levels;
};

/// One entry per mesh of a scene. Empty: every mesh is drawn as it is.
using SceneLevels = std::vector<MeshLevels>;

/// Makes the levels of all meshes, in parallel. The same mesh has the same levels on every call.
[[nodiscard]] SceneLevels make_levels(const Scene& scene);

[[nodiscard]] MeshLevels make_levels(const Mesh& mesh);

}  // namespace farshade
