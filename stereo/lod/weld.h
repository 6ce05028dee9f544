/// Weld: joins the vertices of a mesh that differ so little that a simplifier may treat them as one.
#pragma once

#include "stereo/scene/scene.h"

namespace farshade {

/// The triangles of a mesh over its welded vertices. Triangles that have become lines are left out.
struct WeldedMesh {
  /// For each welded vertex: the vertex of the mesh that represents it, the one whose normal is closest to
  /// the mean.
  std::vector<std::uint32_t> vertices;
  std::vector<glm::uvec3> triangles;  ///< indices into `vertices`
  std::vector<bool> on_seam;          ///< another welded vertex has the same position
};

/// Joins vertices that have the same position, texture coordinates and colour and whose normals differ by
/// less than kSmooth_rad from their mean. Other vertices at one position form a seam, such as a hard edge,
/// which a simplifier keeps.
inline constexpr double kSmooth_rad = 0.5;
[[nodiscard]] WeldedMesh weld(const Mesh& mesh);

}  // namespace farshade
