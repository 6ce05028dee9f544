/// SurfaceModel: the scene's triangles as the tracer meets them.
///
/// What never moves is baked: positions in float relative to the scene's anchor (closeup.h, in double), so
/// that a scene far from the origin keeps its precision. What moves stays in object space about its mesh's
/// centre and is placed by a transform a frame. Triangles are wound so that their counter-clockwise side is
/// the seen one whatever the sign of the transform's determinant.
#pragma once

#include <glm/mat3x3.hpp>
#include <optional>
#include <span>

#include "stereo/plan/scene_plan.h"
#include "stereo/scene/scene_state.h"
#include "stereo/tracer/closeup.h"
#include "stereo/tracer/hole_test.h"

namespace farshade {

/// `reach`: largest absolute coordinate of the triangle's vertices, what its rounding errors are measured by.
struct Facet {
  glm::vec3 normal{0.0f};  ///< unit, towards the counter-clockwise side; zero where the triangle has no area
  float reach = 0;
};

/// Where a moving patch is, anchor-relative.
struct Placement {
  glm::mat3 linear{1.0f};
  glm::vec3 translation{0.0f};
  glm::mat3 normal{1.0f};  ///< inverse transpose up to a positive factor
  float reach = 0;         ///< as Facet::reach for all of its triangles, errors of the transform included
  bool singular = false;   ///< flattened to nothing: not there
};

/// One instance's triangles.
struct Patch {
  std::uint32_t instance = 0;  ///< into Scene::instances
  std::uint32_t first_triangle = 0, triangle_count = 0, first_vertex = 0;
  bool double_sided = false;
  bool back_test = false;  ///< eyes' rays pass its back, if it is not double-sided
  bool moving = false;
  glm::dvec3 object_center{0.0};                 ///< moving only: what the vertices are relative to
  glm::dvec3 object_half{0.0};                   ///< moving only: of the box about them
  double object_reach = 0;                       ///< moving only: largest absolute coordinate of its vertices
  std::optional<HoleTest> holes = std::nullopt;  ///< only where the material needs it
  Placement placement = {};                      ///< moving only
};

class SurfaceModel {
 public:
  /// Refers to `scene`. Instances whose transform in `state` is singular and that never move are left out.
  SurfaceModel(const Scene& scene, const SceneState& state, const TracePlan& plan);

  /// Moves what moves. Patches keep their addresses.
  void place(const SceneState& state);

  [[nodiscard]] const glm::dvec3& anchor() const { return closeup_.anchor; }

  [[nodiscard]] std::span<const Patch> patches() const { return patches_; }
  [[nodiscard]] std::size_t fixed_count() const { return fixed_count_; }  ///< these come first in patches()

  /// All vertices with one unused one at the end (Embree loads 16 bytes), normals (any length), and vertex
  /// numbers.
  [[nodiscard]] std::span<const glm::vec3> positions() const { return positions_; }
  [[nodiscard]] std::span<const glm::vec3> normals() const { return normals_; }
  [[nodiscard]] std::span<const glm::uvec3> triangles() const { return triangles_; }
  [[nodiscard]] std::span<const Facet> facets() const { return facets_; }

 private:
  void add(const Scene& scene, const SceneState& state, std::uint32_t instance, const TracePlan& plan);

  /// `p` as `vertices` say, relative to the anchor, in double; in parts where an edge is longer than
  /// `near_m`.
  void add_triangle(const glm::uvec3& vertices, const std::array<glm::dvec3, 3>& p, double near_m);

  Closeup closeup_;
  std::vector<Patch> patches_;
  std::size_t fixed_count_ = 0;
  std::vector<glm::vec3> positions_, normals_;
  std::vector<glm::uvec3> triangles_;
  std::vector<Facet> facets_;
};

}  // namespace farshade
