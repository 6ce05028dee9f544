/// HoleTest: finds the holes of an alpha-masked surface. Alpha is factor x texture (bilinear, level 0,
/// wrapped) x vertex colour, interpolated over the triangle. Where alpha is below the material's cutoff, the
/// surface is neither seen nor casts.
#pragma once

#include "stereo/scene/scene.h"

namespace farshade {

class HoleTest {
 public:
  /// Keeps references to `mesh` and to the scene's texture. A material without alpha cutoff has no holes.
  HoleTest(const Scene& scene, const Mesh& mesh);

  /// `triangle` holds the mesh's own vertex numbers. The barycentric (u, v) weigh the second and third
  /// vertex.
  [[nodiscard]] bool is_hole(const glm::uvec3& triangle, float u, float v) const;

 private:
  const Mesh* mesh_;
  const Texture* texture_ = nullptr;
  float factor_, cutoff_;
};

}  // namespace farshade
