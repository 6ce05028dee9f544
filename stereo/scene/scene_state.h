/// SceneState: where a scene's instances and lights are at one moment of its animation, in double.
#pragma once

#include "stereo/frame/light_changes.h"
#include "stereo/scene/scene.h"

namespace farshade {

/// A shadow-casting light as shading and tracing need it. `position` means nothing for directional lights,
/// `direction` (unit, the way the light travels) nothing for point lights.
struct Light {
  LightKind kind = LightKind::Point;
  bool on = true;  ///< a light that is off shines nowhere and has no shadows, but keeps its bit
  Point<Stage> position;
  Vector<Stage> direction;
  glm::vec3 intensity{1.0f};
  float range_m = 0;  ///< 0 = unlimited
  float inner_cone_rad = 0, outer_cone_rad = 0;
  friend bool operator==(const Light&, const Light&) = default;
};

/// The lights in a fixed order: bit i of a mask is light i of the scene, whatever is changed about it.
struct LightSet {
  std::uint32_t revision = kFirstLightSet;  ///< of the changes that made it
  std::vector<Light> lights;
};

struct SceneState {
  Time scene_time{};
  std::vector<Affine<Stage, Object>> stage_from_object;  ///< one an instance
  LightSet light_set;
  LightChanges light_changes;  ///< that light_set was made with
};

/// The state at `scene_time` (0 = start; repeats after animation_length_s), its lights as `changes` leave
/// them. Changes of lights that the scene does not have are passed over: a viewer may speak of any.
[[nodiscard]] SceneState state_at(const Scene& scene, Time scene_time, const LightChanges& changes = {});

/// Brings `state`, made from the same scene, to `scene_time` and `changes`: as state_at, but in its memory,
/// and doing nothing where nothing is animated and no light has changed.
void advance(const Scene& scene, Time scene_time, const LightChanges& changes, SceneState& state);

/// `light_set` as the scene has it becomes what `changes` make of it, as in state_at.
void apply(const LightChanges& changes, LightSet& light_set);

/// Each node's own space in the stage. A scale that an animation takes to 0 stays at 1e-9, so that every map
/// can be inverted.
[[nodiscard]] std::vector<Affine<Stage, Object>> stage_from_nodes(const Scene& scene, Time scene_time);

}  // namespace farshade
