/// MovingBounds: the box around everything that a scene shows at one time of its animation.
#pragma once

#include <optional>
#include <vector>

#include "stereo/scene/scene_state.h"

namespace farshade {

class MovingBounds {
 public:
  /// Keeps a reference to the scene.
  explicit MovingBounds(const Scene& scene);
  /// Stage space. It may be larger than the meshes need. Scene::bounds if nothing that is seen can move.
  [[nodiscard]] Bounds at(Time scene_time);

 private:
  struct Shape {
    Bounds still;                         ///< of the mesh, object space
    std::optional<DeformBounds> deforms;  ///< of a mesh that a rig deforms
  };

  const Scene& scene_;
  std::vector<Shape> shapes_;  ///< one per instance; empty: nothing can move
  SceneState state_;
};

}  // namespace farshade
