#include "stereo/gltf/gltf_animation.h"

#include <algorithm>
#include <glm/common.hpp>
#include <numbers>
#include <set>
#include <tuple>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/scene/scene_state.h"

namespace farshade::gltf {
namespace {

constexpr double kMostIntensity = 1e30;
/// A light of a larger range has no limit. Files write the largest float for that.
constexpr double kMostRange_m = 1e30;

Path path_from(const std::string& path) {
  return path == "translation" ? Path::Translation
         : path == "rotation"  ? Path::Rotation
         : path == "scale"     ? Path::Scale
                               : Path::Visible;
}

LightProperty property_from(const std::string& name) {
  return name == "color"                 ? LightProperty::Color
         : name == "intensity"           ? LightProperty::Intensity
         : name == "range"               ? LightProperty::Range
         : name == "spot/innerConeAngle" ? LightProperty::InnerCone
                                         : LightProperty::OuterCone;
}

Interpolation interpolation_from(const std::string& name) {
  return name == "STEP"     ? Interpolation::Step
         : name == "LINEAR" ? Interpolation::Linear
                            : Interpolation::CubicSpline;
}

/// The values of a sampler, with 0 for the components that they do not have.
std::vector<glm::vec4> values_from(const Document& document, const AnimationSampler& sampler) {
  auto values = read_vectors<4>(document, static_cast<std::uint32_t>(sampler.output));
  const auto rows = static_cast<int>(shape_of(at(document.accessors, sampler.output)).rows);
  for (glm::vec4& value : values)
    for (int i = rows; i < 4; ++i) value[i] = 0.0f;
  return values;
}

void set_value(LightProperty property, const glm::dvec4& value, Light& light) {
  if (property == LightProperty::Color) light.color = {value.x, value.y, value.z};
  if (property == LightProperty::Intensity) light.intensity = value.x;
  if (property == LightProperty::Range) light.range = value.x;
  if (property == LightProperty::InnerCone) light.spot.innerConeAngle = value.x;
  if (property == LightProperty::OuterCone) light.spot.outerConeAngle = value.x;
}

/// A bound of the values between all keys. The tangents of a spline add at most 4/27 of their length.
glm::dvec4 largest_value(const LightTrack& track) {
  const bool is_cubic = track.interpolation == Interpolation::CubicSpline;
  const std::size_t parts = is_cubic ? 3 : 1;
  glm::dvec4 result(track.values[first_value(track)]);
  for (std::size_t key = 1; key < track.keys_s.size(); ++key) {
    const auto value = [&](std::size_t of, std::size_t part) {
      return glm::dvec4(track.values[of * parts + part]);
    };
    glm::dvec4 bound = glm::max(value(key - 1, is_cubic ? 1 : 0), value(key, is_cubic ? 1 : 0));
    const double step_s = double{track.keys_s[key]} - double{track.keys_s[key - 1]};
    if (is_cubic) bound += step_s * 4 / 27 * (glm::abs(value(key - 1, 2)) + glm::abs(value(key, 0)));
    result = glm::max(result, bound);
  }
  return result;
}

void add_track(LightTrack track, AnimatedLight& to) {
  if (is_constant(track))
    set_value(track.property, glm::dvec4(track.values[first_value(track)]), to.rest);
  else
    to.tracks.push_back(std::move(track));
}

void add_channel(Channel channel, Scene& scene) {
  if (channel.path == Path::Visible) {
    channel.interpolation = Interpolation::Step;
    for (glm::vec4& value : channel.values) value.x = value.x != 0 ? 1.0f : 0.0f;
  }
  farshade::Node& node = scene.nodes[channel.node];
  if (is_constant(channel)) {
    set(channel.path, glm::dvec4(channel.values[first_value(channel)]), node.rest);
  } else {
    node.moving |= channel.path != Path::Visible;
    scene.channels.push_back(std::move(channel));
  }
}

/// The lights that nodes of the scene carry.
std::set<int> lights_in_scene(const Document& document, const std::vector<Index>& scene_node) {
  std::set<int> used;
  for (std::size_t node = 0; node < scene_node.size(); ++node)
    if (const Index light = light_of(document.nodes[node]); light && scene_node[node])
      used.insert(static_cast<int>(*light));
  return used;
}

/// False for weights of no morph target, and for the range of a directional light.
bool has_property(const Document& document, const AnimationChannel& channel) {
  if (moves_light(channel))
    return channel.target_path != "range" || at(document.lights, channel.target_node).type != "directional";
  const int mesh = at(document.nodes, channel.target_node).mesh;
  return channel.target_path != "weights" || (mesh >= 0 && targets_of(at(document.meshes, mesh)) > 0);
}

}  // namespace

Moving add_animations(const Document& document, const std::vector<Index>& scene_node, Scene& scene) {
  Moving moving;
  for (const Light& light : document.lights) moving.lights.push_back({light, {}});
  const std::set<int> lights = lights_in_scene(document, scene_node);
  std::set<std::tuple<bool, int, std::string>> taken;
  double length_s = 0;
  for (const Animation& animation : document.animations)
    for (const AnimationChannel& from : animation.channels) {
      const int target = from.target_node;
      const bool is_there = moves_light(from) ? lights.contains(target) : at(scene_node, target).has_value();
      if (!is_there || !has_property(document, from)) continue;
      if (!taken.emplace(moves_light(from), target, from.target_path).second) continue;
      const AnimationSampler& sampler = at(animation.samplers, from.sampler);
      const Interpolation interpolation = interpolation_from(sampler.interpolation);
      const auto keys_s = read_scalars(document, static_cast<std::uint32_t>(sampler.input));
      length_s = std::max(length_s, double{keys_s.back()});
      if (moves_light(from)) {
        const LightProperty property = property_from(from.target_path);
        add_track({property, interpolation, keys_s, values_from(document, sampler)},
                  at(moving.lights, target));
      } else if (from.target_path == "weights") {
        auto weights = read_scalars(document, static_cast<std::uint32_t>(sampler.output));
        for (float& weight : weights)
          weight = glm::clamp(weight, static_cast<float>(-kMostWeight), static_cast<float>(kMostWeight));
        moving.weights[target] = {interpolation, keys_s, std::move(weights)};
      } else {
        add_channel({*at(scene_node, target), path_from(from.target_path), interpolation, keys_s,
                     values_from(document, sampler)},
                    scene);
      }
    }
  const auto changes = [](const AnimatedLight& light) { return !light.tracks.empty(); };
  if (!scene.channels.empty() || !moving.weights.empty() || std::ranges::any_of(moving.lights, changes))
    scene.animation_length_s = length_s;
  for (farshade::Node& node : scene.nodes)
    if (node.parent && scene.nodes[*node.parent].moving) node.moving = true;
  return moving;
}

LightSource light_from(const AnimatedLight& from, std::uint32_t node) {
  const Light& rest = from.rest;
  Light largest = rest;
  for (const LightTrack& track : from.tracks) set_value(track.property, largest_value(track), largest);
  const auto color_of = [](const Light& light) { return vector_of(light.color, glm::dvec3(1.0)); };
  LightSource to;
  to.name = rest.name;
  to.node = node;
  to.kind = rest.type == "point"  ? LightKind::Point
            : rest.type == "spot" ? LightKind::Spot
                                  : LightKind::Directional;
  if (!from.tracks.empty())
    to.animation = {glm::vec3(glm::min(color_of(rest), kMostIntensity)),
                    static_cast<float>(std::min(rest.intensity, kMostIntensity)), 1, from.tracks};
  to.intensity = glm::vec3(glm::min(color_of(largest) * largest.intensity, kMostIntensity));
  // tinygltf writes 0 for a light without a range.
  if (largest.range > 0 && largest.range < kMostRange_m && to.kind != LightKind::Directional)
    to.range_m = static_cast<float>(largest.range);
  if (to.kind != LightKind::Spot) return to;
  to.inner_cone_rad = static_cast<float>(rest.spot.innerConeAngle);
  to.outer_cone_rad = static_cast<float>(std::min(largest.spot.outerConeAngle, std::numbers::pi / 2));
  return to;
}

}  // namespace farshade::gltf
