/// SceneState: the transforms of the instances and the lights of a scene at one time of its animation.
#pragma once

#include "stereo/frame/exposure.h"
#include "stereo/frame/light_changes.h"
#include "stereo/scene/deform.h"
#include "stereo/scene/scene.h"

namespace farshade {

/// A shadow-casting light, for shading and tracing. `position` is undefined for directional lights.
/// `direction` (unit, in the direction in which the light travels) is undefined for point lights.
struct Light {
  LightKind kind = LightKind::Point;
  bool on = true;  ///< a light that is off lights nothing, but keeps its bit in the masks
  Point<Stage> position;
  Vector<Stage> direction;
  glm::vec3 intensity{1.0f};
  float range_m = 0;  ///< 0 = unlimited
  float inner_cone_rad = 0, outer_cone_rad = 0;
  float widest_cone_rad = 0;  ///< the outer cone at its widest; shadow maps are made for it
  friend bool operator==(const Light&, const Light&) = default;
};

/// The lights in a fixed order: bit i of a mask belongs to light i of the scene, also after light changes.
struct LightSet {
  LightSetRevision revision = kFirstLightSet;  ///< revision of the light changes that were applied
  std::vector<Light> lights;
  Exposure exposure{};  ///< multiplies what is drawn of all lights
};

struct SceneState {
  Time scene_time{};
  std::vector<Affine<Stage, Object>> stage_from_object;  ///< one per instance
  std::vector<RigPose> rigs;                             ///< one per rig of the scene
  LightSet light_set;
  LightChanges light_changes;  ///< the changes that were applied to light_set
};

/// The state at `scene_time` (0 = start; repeats after animation_length_s), with `changes` applied to the
/// lights. Ignores changes of lights that the scene does not have.
[[nodiscard]] SceneState state_at(const Scene& scene, Time scene_time, const LightChanges& changes = {});

/// Updates `state`, which was made from the same scene, to `scene_time` and `changes`. The result is the same
/// as from state_at. Reuses memory, and does nothing if neither animation nor changes alter the state.
void advance(const Scene& scene, Time scene_time, const LightChanges& changes, SceneState& state);

/// Applies `changes` to a light set that has the lights of the scene, as state_at does.
void apply(const LightChanges& changes, LightSet& light_set);

/// Sets one property to a channel's value: xyz0 or a quaternion xyzw of any length. A spline may pass through
/// 0, which is no rotation; the node then keeps its rotation.
void set(Path path, const glm::dvec4& value, NodeTransform& transform);

/// Whether float cannot tell the volume of the transformed unit cube from 0. An instance with such a
/// transform is not there: nobody sees it, and it casts no shadow. Both the tracer and the rasteriser leave
/// it out.
[[nodiscard]] bool is_singular(const glm::dmat3& linear);

/// The transform of each node to the stage. A scale below 1e-9 times the largest of its node, or times 1, is
/// replaced by that, so that a node that an animation flattens is still there.
[[nodiscard]] std::vector<Affine<Stage, Object>> stage_from_nodes(const Scene& scene, Time scene_time);

/// The transform of each instance to the stage at time 0, also of those that an animation hides then: for
/// what is found out once and must hold when they are shown.
[[nodiscard]] std::vector<Affine<Stage, Object>> places_at_start(const Scene& scene);

/// Where the vertices of a skin are relative to: the stage's axes about the first joint.
[[nodiscard]] Affine<Stage, Object> stage_from_skin(const Rig& rig,
                                                    std::span<const Affine<Stage, Object>> stage_from_node);

/// The pose of a rig; `stage_from_node` has a transform for each node of the scene, as stage_from_nodes makes
/// them.
[[nodiscard]] RigPose pose_of(const Scene& scene, const Rig& rig,
                              std::span<const Affine<Stage, Object>> stage_from_node, Time scene_time);

}  // namespace farshade
