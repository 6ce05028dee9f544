/// PartMotion: how a part of a deformed mesh has moved, as one affine transform. It is fitted to some
/// vertices and to points above them along their normals, so that flat parts determine it, too. Parts are
/// small (mesh_parts.h), so what it leaves out is small; points that it misses by more than the tolerance of
/// the lookup count as unknown, as all that no mask has seen.
#pragma once

#include <vector>

#include "stereo/scene/scene_state.h"

namespace farshade {

class PartMotion {
 public:
  /// Of an instance that a rig deforms. Keeps a reference to the scene.
  PartMotion(const Scene& scene, std::uint32_t instance);

  /// The transform from the stage now to the stage then; empty if the part has not moved.
  [[nodiscard]] std::optional<glm::dmat4> then_from_now(const SceneState& then, const SceneState& now) const;

  /// A box around the part, in the instance's object space.
  [[nodiscard]] Bounds bounds(const SceneState& state) const { return bounds_.at(state.rigs[rig_]); }

 private:
  [[nodiscard]] std::vector<glm::dvec3> points(const SceneState& state) const;

  const Scene& scene_;
  std::uint32_t instance_ = 0, rig_ = 0;
  std::vector<std::uint32_t> vertices_;  ///< those that the transform is fitted to
  double lift_ = 0;                      ///< metres above them, in object space
  DeformBounds bounds_;
};

}  // namespace farshade
