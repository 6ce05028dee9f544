/// Deform: where a rig moves the vertices of a mesh at one time. The results are in the instance's object
/// space: that of its node for morph targets, and for skins the stage's axes about the first joint, so that
/// float keeps its digits far from the origin. Tracer and G-buffer both use it, and so agree on every vertex.
#pragma once

#include <glm/mat4x4.hpp>
#include <span>

#include "stereo/scene/scene.h"

namespace farshade {

/// A rig at one time.
struct RigPose {
  std::vector<glm::mat4> object_from_bind;  ///< one per joint
  std::vector<float> weights;               ///< of the morph targets
  friend bool operator==(const RigPose&, const RigPose&) = default;
};

struct DeformedVertex {
  glm::vec3 position{0.0f}, normal{0.0f};  ///< unit normal
};

/// A deformable under a rig's pose. Keeps references to both.
class Deformation {
 public:
  Deformation(const Deformable& deformable, const RigPose& pose);

  [[nodiscard]] DeformedVertex vertex(std::size_t index) const;
  /// Writes all vertices; spans of one entry per vertex.
  void write(std::span<glm::vec3> positions, std::span<glm::vec3> normals) const;

 private:
  struct Active {
    const Deformable::Target* target;
    float weight;
  };
  [[nodiscard]] DeformedVertex morphed(std::size_t index) const;
  [[nodiscard]] DeformedVertex blended(std::size_t index) const;
  [[nodiscard]] DeformedVertex skinned(std::size_t index) const;  ///< at the origin if it is beyond 1e12 m
  [[nodiscard]] glm::vec3 facet_normal(std::size_t index) const;

  const Deformable& deformable_;
  const RigPose& pose_;
  std::vector<Active> active_;  ///< targets with a weight
};

/// Boxes from which the bounds of a deformed mesh follow without looking at its vertices. A skinned vertex is
/// a convex combination of places that its joints give it.
class DeformBounds {
 public:
  explicit DeformBounds(const Deformable& deformable);
  /// A box around all vertices under `pose`, object space. It may be larger than the mesh needs.
  [[nodiscard]] Bounds at(const RigPose& pose) const;
  /// Whether both poses certainly give all vertices the same places.
  [[nodiscard]] bool same(const RigPose& a, const RigPose& b) const;

 private:
  struct JointBox {
    std::uint16_t joint;
    Bounds box;  ///< of the vertices that follow the joint, before deformation
  };
  std::vector<JointBox> joints_;  ///< empty: no skin
  Bounds all_;
  std::vector<Bounds> targets_;  ///< of the differences
};

}  // namespace farshade
