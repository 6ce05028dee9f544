#include "stereo/scene/scene_state.h"

#include <algorithm>
#include <cmath>

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

/// Cubic Hermite spline of glTF 2.0 appendix C.5. Tangents are scaled by the time between keys.
glm::dvec4 cubic(const Channel& channel, std::size_t key, double t, double step_s) {
  const auto value = [&](std::size_t k, std::size_t part) {
    return glm::dvec4(channel.values[3 * k + part]);
  };
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * value(key, 1) + step_s * (t3 - 2 * t2 + t) * value(key, 2) +
         (3 * t2 - 2 * t3) * value(key + 1, 1) + step_s * (t3 - t2) * value(key + 1, 0);
}

/// The value of the channel: xyz0, or a quaternion xyzw that may not be unit. It is constant before the first
/// key and after the last key.
glm::dvec4 sample(const Channel& channel, double time_s) {
  const bool is_cubic = channel.interpolation == Interpolation::CubicSpline;
  const auto value = [&](std::size_t k) { return glm::dvec4(channel.values[is_cubic ? 3 * k + 1 : k]); };
  const auto& keys = channel.keys_s;
  const auto next =
      static_cast<std::size_t>(std::upper_bound(keys.begin(), keys.end(), time_s,
                                                [](double t, float key) { return t < double{key}; }) -
                               keys.begin());
  if (next == 0) return value(0);
  if (next == keys.size() || channel.interpolation == Interpolation::Step) return value(next - 1);
  const double step_s = double{keys[next]} - double{keys[next - 1]};
  const double t = (time_s - double{keys[next - 1]}) / step_s;
  if (is_cubic) return cubic(channel, next - 1, t, step_s);
  const glm::dvec4 a = value(next - 1), b = value(next);
  if (channel.path == Path::Rotation) return vec_of(slerp(quat_of(a), quat_of(b), t));
  return a + (b - a) * t;
}

glm::dmat4 local_matrix(const NodeTransform& transform) {
  if (transform.matrix) return *transform.matrix;
  glm::dmat4 m = glm::mat4_cast(transform.rotation);
  for (int axis = 0; axis < 3; ++axis) {
    const double scale = transform.scale[axis];
    m[axis] *= std::abs(scale) < kLeastScale ? std::copysign(kLeastScale, scale) : scale;
  }
  m[3] = glm::dvec4(transform.translation, 1.0);
  return m;
}

Light light_at(const LightSource& source, const Affine<Stage, Object>& stage_from_node) {
  Light light;
  light.kind = source.kind;
  light.position = stage_from_node(Point<Object>{});
  light.direction = {glm::normalize(stage_from_node(Vector<Object>{{0, 0, -1}}).v)};
  light.intensity = source.intensity;
  light.range_m = source.range_m.value_or(0.0f);
  light.inner_cone_rad = source.inner_cone_rad;
  light.outer_cone_rad = source.outer_cone_rad;
  return light;
}

}  // namespace

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

void advance(const Scene& scene, Time scene_time, const LightChanges& changes, SceneState& state) {
  state.scene_time = scene_time;
  const bool is_made = state.stage_from_object.size() == scene.instances.size() &&
                       state.light_set.lights.size() == scene.lights.size();
  if (is_made && scene.channels.empty() && changes == state.light_changes) return;
  const auto poses = stage_from_nodes(scene, scene_time);
  state.stage_from_object.clear();
  for (const Instance& instance : scene.instances) state.stage_from_object.push_back(poses[instance.node]);
  state.light_set.lights.clear();
  for (const LightSource& source : scene.lights)
    state.light_set.lights.push_back(light_at(source, poses[source.node]));
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

}  // namespace farshade
