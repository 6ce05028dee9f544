#include "stereo/scene/moving_bounds.h"

#include <algorithm>

namespace farshade {

MovingBounds::MovingBounds(const Scene& scene) : scene_(scene) {
  if (std::ranges::none_of(scene.instances, [&](const Instance& i) { return can_move(scene, i); })) return;
  state_ = state_at(scene, Time{});
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    Shape& shape = shapes_.emplace_back(Shape{bounds_of(mesh.positions), std::nullopt});
    if (instance.rig) shape.deforms.emplace(*mesh.deformable);
  }
}

Bounds MovingBounds::at(Time scene_time) {
  if (shapes_.empty()) return scene_.bounds;
  advance(scene_, scene_time, {}, state_);
  Bounds all = kNoPoint;
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    const auto& [still, deforms] = shapes_[i];
    const Bounds object = deforms ? deforms->at(state_.rigs[*scene_.instances[i].rig]) : still;
    all = joined(all, moved(state_.stage_from_object[i].matrix, object));
  }
  return all;
}

}  // namespace farshade
