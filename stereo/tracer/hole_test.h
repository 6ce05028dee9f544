/// Where an alpha-masked surface is a hole: alpha = factor x texture (bilinear, level 0, wrapped) x vertex
/// colour, interpolated over the triangle; below the material's cutoff nothing is seen and nothing casts.
#pragma once

#include <span>

#include "stereo/scene/scene.h"

namespace farshade {

class HoleTest {
 public:
  /// `mesh` and the scene's texture are referred to. Without an alpha cutoff nothing is a hole.
  HoleTest(const Scene& scene, const Mesh& mesh);

  /// Vertex numbers are the mesh's own; (u, v) weigh the second and third.
  [[nodiscard]] bool is_hole(const glm::uvec3& triangle, float u, float v) const;

 private:
  const Mesh* mesh_;
  const Texture* texture_ = nullptr;
  float factor_, cutoff_;
};

}  // namespace farshade
