/// SurfaceModel: the scene's triangles as the tracer intersects them.
///
/// Instances that never move are transformed once, in double, to anchor space (anchor_space.h), and stored in
/// float. Instances that move keep their object space, with the origin at the mesh's centre, and are placed
/// by a transform per frame. The vertices of instances that a rig deforms are
/// computed anew in each frame, too. Triangles are wound so that the counter-clockwise side is the seen one,
/// whatever the sign of the transform's determinant.
#pragma once

#include <glm/mat3x3.hpp>
#include <optional>
#include <span>

#include "stereo/plan/scene_plan.h"
#include "stereo/scene/scene_state.h"
#include "stereo/tracer/closeup.h"
#include "stereo/tracer/hole_test.h"

namespace farshade {

struct Facet {
  glm::vec3 normal{0.0f};  ///< unit, towards the counter-clockwise side; zero if the triangle has no area
  float reach = 0;  ///< largest absolute coordinate of its vertices; rounding errors are proportional to it
};

/// Maps the vertices of a moving patch to anchor space.
struct Placement {
  glm::mat3 linear{1.0f};
  FloatPoint<Anchor> translation{};  ///< where the mesh's centre is
  glm::mat3 normal{1.0f};            ///< inverse transpose, times any positive factor
  float reach = 0;        ///< as Facet::reach, for all of the patch, with the errors of the transform
  bool singular = false;  ///< the transform is singular: the instance does not exist

  [[nodiscard]] glm::vec3 operator()(const glm::vec3& vertex) const {
    return linear * vertex + translation.v;
  }
};

/// The triangles of one instance.
struct Patch {
  std::uint32_t instance = 0;  ///< into Scene::instances
  std::uint32_t first_triangle = 0, triangle_count = 0, first_vertex = 0;
  bool double_sided = false;
  bool back_test = false;  ///< primary rays pass its back faces, unless it is double-sided
  bool moving = false;
  bool casts = true;                                ///< shadow rays meet it
  std::optional<std::uint32_t> rig = std::nullopt;  ///< deforms the patch; patches of a rig share a placement
  std::uint32_t vertex_count = 0;
  Point<Object>
      object_center{};  ///< moving only: the origin of its vertices; the centre of their box, or 0 with a rig
  double object_reach = 0;                       ///< moving only: largest absolute coordinate of its vertices
  std::optional<HoleTest> holes = std::nullopt;  ///< only if the material has holes
  Placement placement = {};                      ///< moving only
};

class SurfaceModel {
 public:
  /// Keeps references to `scene`. Leaves out instances that never move and whose transform is singular.
  SurfaceModel(const Scene& scene, const SceneState& state, const TracePlan& plan);

  /// Places and deforms the moving patches. Patches and vertices keep their addresses.
  void place(const SceneState& state);

  [[nodiscard]] const Rigid<Anchor, Stage>& anchor_from_stage() const { return anchor_from_stage_; }

  [[nodiscard]] std::span<const Patch> patches() const { return patches_; }
  [[nodiscard]] std::size_t fixed_count() const {
    return fixed_count_;
  }  ///< fixed patches come first in patches()

  /// Vertices of all patches and one unused vertex at the end (Embree loads 16 bytes), normals of any length,
  /// and the vertex numbers of the triangles. Vertices of fixed patches are in anchor space.
  [[nodiscard]] std::span<const glm::vec3> positions() const { return positions_; }
  [[nodiscard]] std::span<const glm::vec3> normals() const { return normals_; }
  [[nodiscard]] std::span<const glm::uvec3> triangles() const { return triangles_; }
  [[nodiscard]] std::span<const Facet> facets() const { return facets_; }

 private:
  void deform(const SceneState& state, Patch& patch);
  void add(const Scene& scene, const SceneState& state, std::uint32_t instance, const TracePlan& plan);

  /// `p` are the positions of `vertices` in double.
  void add_triangle(const glm::uvec3& vertices, const std::array<glm::dvec3, 3>& p);
  /// The same for a fixed patch: adds the triangle in parts if an edge is too long (closeup.h).
  void add_split(const glm::uvec3& vertices, const std::array<Point<Anchor>, 3>& p);

  const Scene& scene_;
  Closeup closeup_;
  Rigid<Anchor, Stage> anchor_from_stage_;
  std::vector<Patch> patches_;
  std::size_t fixed_count_ = 0;
  std::vector<glm::vec3> positions_, normals_;
  std::vector<glm::uvec3> triangles_;
  std::vector<Facet> facets_;
};

}  // namespace farshade
