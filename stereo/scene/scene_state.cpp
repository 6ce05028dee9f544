#include "stereo/scene/scene_state.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stereo/base/check.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

constexpr double kLeastScale = 1e-9;

/// Time within one repetition of the animation, in [0, length).
double animation_time_s(const Scene& scene, Time time) {
  const auto length_ns = std::llround(scene.animation_length_s * 1e9);
  if (length_ns <= 0) return 0.0;
  const std::int64_t into = ns_of(time) % length_ns;
  return static_cast<double>(into < 0 ? into + length_ns : into) * 1e-9;
}

glm::dquat quat_of(const glm::dvec4& xyzw) {
  return glm::normalize(glm::dquat(xyzw.w, xyzw.x, xyzw.y, xyzw.z));
}
glm::dvec4 vec_of(const glm::dquat& q) {
  return {q.x, q.y, q.z, q.w};
}

/// The place of a time between keys. Before the first key and after the last one it is at that key.
struct KeyPlace {
  std::size_t key = 0;  ///< the last one that is not later
  double t = 0;         ///< part of the way to the next key; 0: at `key`
  double step_s = 0;    ///< between both keys
};

KeyPlace place_of(const std::vector<float>& keys_s, Interpolation interpolation, double time_s) {
  const auto later =
      std::ranges::upper_bound(keys_s, time_s, std::less<>(), [](float key) { return double{key}; });
  const auto next = static_cast<std::size_t>(later - keys_s.begin());
  if (next == 0) return {};
  if (next == keys_s.size() || interpolation == Interpolation::Step) return {.key = next - 1};
  const double step_s = double{keys_s[next]} - double{keys_s[next - 1]};
  return {next - 1, (time_s - double{keys_s[next - 1]}) / step_s, step_s};
}

/// Cubic Hermite spline of glTF 2.0 appendix C.5. `value(key, part)`: in-tangent, value, out-tangent.
/// Tangents are scaled by the time between keys.
template <class Value>
auto cubic(const KeyPlace& at, const Value& value) {
  const double t = at.t, t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * value(at.key, 1) + at.step_s * (t3 - 2 * t2 + t) * value(at.key, 2) +
         (3 * t2 - 2 * t3) * value(at.key + 1, 1) + at.step_s * (t3 - t2) * value(at.key + 1, 0);
}

glm::dvec4 straight(const glm::dvec4& a, const glm::dvec4& b, double t) {
  return a + (b - a) * t;
}

/// The value of a Channel or LightTrack. It is constant before the first key and after the last key.
/// `between(a, b, t)` interpolates where the track is linear.
template <class Track, class Between>
glm::dvec4 sample(const Track& track, double time_s, const Between& between) {
  const bool is_cubic = track.interpolation == Interpolation::CubicSpline;
  const KeyPlace at = place_of(track.keys_s, track.interpolation, time_s);
  const auto value = [&](std::size_t k, std::size_t part) {
    return glm::dvec4(track.values[is_cubic ? 3 * k + part : k]);
  };
  if (at.t == 0) return value(at.key, 1);
  if (is_cubic) return cubic(at, value);
  return between(value(at.key, 1), value(at.key + 1, 1), at.t);
}

/// xyz0, or a quaternion xyzw that may not be unit.
glm::dvec4 sample(const Channel& channel, double time_s) {
  if (channel.path != Path::Rotation) return sample(channel, time_s, straight);
  return sample(channel, time_s, [](const glm::dvec4& a, const glm::dvec4& b, double t) {
    return vec_of(slerp(quat_of(a), quat_of(b), t));
  });
}

/// One of `count` weights.
double sample(const WeightTrack& track, std::size_t count, std::size_t index, double time_s) {
  const bool is_cubic = track.interpolation == Interpolation::CubicSpline;
  const KeyPlace at = place_of(track.keys_s, track.interpolation, time_s);
  const auto value = [&](std::size_t k, std::size_t part) {
    return double{track.values[(is_cubic ? 3 * k + part : k) * count + index]};
  };
  if (at.t == 0) return value(at.key, 1);
  if (is_cubic) return cubic(at, value);
  return value(at.key, 1) + (value(at.key + 1, 1) - value(at.key, 1)) * at.t;
}

glm::dmat4 local_matrix(const NodeTransform& transform) {
  if (transform.matrix) return *transform.matrix;
  glm::dmat4 m = glm::mat4_cast(transform.rotation);
  const glm::dvec3 sizes = glm::abs(transform.scale);
  const double least = kLeastScale * std::max({1.0, sizes.x, sizes.y, sizes.z});
  for (int axis = 0; axis < 3; ++axis)
    m[axis] *= sizes[axis] < least ? std::copysign(least, transform.scale[axis]) : transform.scale[axis];
  m[3] = glm::dvec4(transform.translation, 1.0);
  return m;
}

/// Sets what an animation changes. A spline may leave the range of the property's values; it is cut off.
void animate(const LightAnimation& animation, double time_s, Light& light) {
  constexpr double kLeastRange_m = 1e-6, kLeastCone_rad = 1e-4, kMostIntensity = 1e30;
  glm::dvec3 color(animation.color);
  double intensity = double{animation.intensity}, inner = double{light.inner_cone_rad},
         outer = double{light.outer_cone_rad};
  for (const LightTrack& track : animation.tracks) {
    const glm::dvec4 value = sample(track, time_s, straight);
    switch (track.property) {
      case LightProperty::Color:
        color = glm::max(glm::dvec3(value), 0.0);
        break;
      case LightProperty::Intensity:
        intensity = std::max(value.x, 0.0);
        break;
      case LightProperty::Range:
        light.range_m = static_cast<float>(std::max(value.x, kLeastRange_m));
        break;
      case LightProperty::InnerCone:
        inner = value.x;
        break;
      case LightProperty::OuterCone:
        outer = value.x;
        break;
    }
  }
  light.intensity =
      glm::vec3(glm::min(color * intensity * double{animation.exposure}, glm::dvec3(kMostIntensity)));
  if (light.kind != LightKind::Spot) return;
  outer = std::clamp(outer, kLeastCone_rad, std::numbers::pi / 2);
  light.outer_cone_rad = static_cast<float>(outer);
  light.inner_cone_rad = static_cast<float>(std::clamp(inner, 0.0, outer));
}

Light light_at(const LightSource& source, const Affine<Stage, Object>& stage_from_node, double time_s) {
  Light light;
  light.kind = source.kind;
  light.position = stage_from_node(Point<Object>{});
  light.direction = {glm::normalize(stage_from_node(Vector<Object>{{0, 0, -1}}).v)};
  light.intensity = source.intensity;
  light.range_m = source.range_m.value_or(0.0f);
  light.inner_cone_rad = source.inner_cone_rad;
  light.outer_cone_rad = light.widest_cone_rad = source.outer_cone_rad;
  if (source.animation) animate(*source.animation, time_s, light);
  return light;
}

bool is_animated(const LightSource& light) {
  return light.animation.has_value();
}

/// Whether animations show each node. What is below a hidden node is hidden.
std::vector<bool> shown_nodes(const Scene& scene, double time_s) {
  std::vector<bool> shown(scene.nodes.size(), true);
  for (const Channel& channel : scene.channels)
    if (channel.path == Path::Visible) shown[channel.node] = sample(channel, time_s).x != 0;
  for (std::size_t i = 0; i < shown.size(); ++i)
    if (const auto parent = scene.nodes[i].parent; parent && !shown[*parent]) shown[i] = false;
  return shown;
}

/// The transform of an instance, hidden or not.
Affine<Stage, Object> place_of(const Scene& scene, const Instance& instance,
                               std::span<const Affine<Stage, Object>> stage_from_node) {
  const bool skinned = instance.rig && !scene.rigs[*instance.rig].joints.empty();
  return skinned ? stage_from_skin(scene.rigs[*instance.rig], stage_from_node)
                 : stage_from_node[instance.node];
}

/// What is hidden has no extent, so it is not there (is_singular).
Affine<Stage, Object> hidden(Affine<Stage, Object> pose) {
  pose.matrix[0] = pose.matrix[1] = pose.matrix[2] = glm::dvec4(0.0);
  return pose;
}

}  // namespace

bool changes_reach(const LightSource& light) {
  return light.animation && std::ranges::any_of(light.animation->tracks, [](const LightTrack& track) {
           return track.property == LightProperty::Range || track.property == LightProperty::OuterCone;
         });
}

void set(Path path, const glm::dvec4& value, NodeTransform& transform) {
  switch (path) {
    case Path::Translation:
      transform.translation = glm::dvec3(value);
      break;
    case Path::Scale:
      transform.scale = glm::dvec3(value);
      break;
    case Path::Rotation:
      if (glm::length(value) > 1e-6) transform.rotation = quat_of(value);
      break;
    case Path::Visible:
      transform.visible = value.x != 0;
      break;
  }
}

std::vector<Affine<Stage, Object>> stage_from_nodes(const Scene& scene, Time scene_time) {
  std::vector<NodeTransform> locals(scene.nodes.size());
  for (std::size_t i = 0; i < locals.size(); ++i) locals[i] = scene.nodes[i].rest;
  const double time_s = animation_time_s(scene, scene_time);
  for (const Channel& channel : scene.channels)
    set(channel.path, sample(channel, time_s), locals[channel.node]);
  std::vector<Affine<Stage, Object>> result(scene.nodes.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto parent = scene.nodes[i].parent;
    check(!parent || *parent < i, "nodes are ordered parents first");
    const glm::dmat4 local = local_matrix(locals[i]);
    result[i].matrix = parent ? result[*parent].matrix * local : local;
  }
  return result;
}

void apply(const LightChanges& changes, LightSet& light_set) {
  light_set.revision = changes.revision;
  for (const LightChange& change : changes.lights) {
    if (change.light >= light_set.lights.size()) continue;
    Light& light = light_set.lights[change.light];
    light.on = change.on;
    if (!change.pose) continue;
    light.position = change.pose->position;
    light.direction = change.pose->direction;
  }
}

Affine<Stage, Object> stage_from_skin(const Rig& rig,
                                      std::span<const Affine<Stage, Object>> stage_from_node) {
  Affine<Stage, Object> result;
  result.matrix[3] = stage_from_node[rig.joints.at(0).node].matrix[3];
  return result;
}

RigPose pose_of(const Scene& scene, const Rig& rig, std::span<const Affine<Stage, Object>> stage_from_node,
                Time scene_time) {
  RigPose pose;
  if (!rig.joints.empty()) {
    const glm::dvec3 origin(stage_from_skin(rig, stage_from_node).matrix[3]);
    for (const Joint& joint : rig.joints) {
      glm::dmat4 object_from_joint = stage_from_node[joint.node].matrix;
      object_from_joint[3] -= glm::dvec4(origin, 0.0);
      pose.object_from_bind.emplace_back(object_from_joint * joint.joint_from_bind);
    }
  }
  pose.weights = rig.weights;
  const double time_s = animation_time_s(scene, scene_time);
  for (std::size_t i = 0; rig.track && i < pose.weights.size(); ++i)
    pose.weights[i] = static_cast<float>(sample(*rig.track, pose.weights.size(), i, time_s));
  return pose;
}

std::vector<Affine<Stage, Object>> places_at_start(const Scene& scene) {
  const auto poses = stage_from_nodes(scene, Time{});
  std::vector<Affine<Stage, Object>> places;
  for (const Instance& instance : scene.instances) places.push_back(place_of(scene, instance, poses));
  return places;
}

void advance(const Scene& scene, Time scene_time, const LightChanges& changes, SceneState& state) {
  state.scene_time = scene_time;
  const bool is_made = state.stage_from_object.size() == scene.instances.size() &&
                       state.light_set.lights.size() == scene.lights.size();
  const bool stands =
      scene.channels.empty() && scene.rigs.empty() && std::ranges::none_of(scene.lights, is_animated);
  if (is_made && stands && changes == state.light_changes) return;
  const auto poses = stage_from_nodes(scene, scene_time);
  state.rigs.clear();
  for (const Rig& rig : scene.rigs) state.rigs.push_back(pose_of(scene, rig, poses, scene_time));
  state.stage_from_object.clear();
  const double time_s = animation_time_s(scene, scene_time);
  const std::vector<bool> shown = shown_nodes(scene, time_s);
  for (const Instance& instance : scene.instances) {
    const auto pose = place_of(scene, instance, poses);
    const bool hides = instance.shown_with && !shown[*instance.shown_with];
    state.stage_from_object.push_back(hides ? hidden(pose) : pose);
  }
  state.light_set.lights.clear();
  for (const LightSource& source : scene.lights) {
    Light& light = state.light_set.lights.emplace_back(light_at(source, poses[source.node], time_s));
    if (source.hides && !shown[source.node]) light.intensity = glm::vec3(0.0f);
  }
  state.light_changes = changes;
  apply(changes, state.light_set);
}

SceneState state_at(const Scene& scene, Time scene_time, const LightChanges& changes) {
  SceneState state;
  state.stage_from_object.reserve(scene.instances.size());
  state.light_set.lights.reserve(scene.lights.size());
  advance(scene, scene_time, changes, state);
  return state;
}

bool is_singular(const glm::dmat3& linear) {
  // A flattened node keeps the share kLeastScale of its volume, and a node flattened to a line kLeastScale^2.
  // Any threshold between the two would do.
  const double longest = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
  return !(std::abs(glm::determinant(linear)) > 1e-12 * longest * longest * longest);
}

}  // namespace farshade
