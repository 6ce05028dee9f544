#include "stereo/gltf/gltf_lights.h"

#include <algorithm>
#include <glm/common.hpp>
#include <numbers>
#include <set>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_animation.h"

namespace farshade::gltf {
namespace {

constexpr double kMostIntensity = 1e30;
/// A light of a larger range has no limit. Files write the largest float for that.
constexpr double kMostRange_m = 1e30;

LightProperty property_from(const std::string& name) {
  return name == "color"                 ? LightProperty::Color
         : name == "intensity"           ? LightProperty::Intensity
         : name == "range"               ? LightProperty::Range
         : name == "spot/innerConeAngle" ? LightProperty::InnerCone
                                         : LightProperty::OuterCone;
}

LightTrack track_from(const Document& document, const AnimationSampler& sampler, LightProperty property) {
  const auto input = static_cast<std::uint32_t>(sampler.input),
             output = static_cast<std::uint32_t>(sampler.output);
  LightTrack track{property, interpolation_from(sampler.interpolation), read_scalars(document, input), {}};
  if (property == LightProperty::Color) {
    for (const glm::vec3& color : read_vectors<3>(document, output)) track.values.emplace_back(color, 0.0f);
  } else {
    for (const float value : read_scalars(document, output)) track.values.emplace_back(value, 0, 0, 0);
  }
  return track;
}

void set_value(LightProperty property, const glm::dvec4& value, LightValues& light) {
  if (property == LightProperty::Color) light.color = glm::dvec3(value);
  if (property == LightProperty::Intensity) light.intensity = value.x;
  if (property == LightProperty::Range) light.range_m = value.x;
  if (property == LightProperty::InnerCone) light.inner_cone_rad = value.x;
  if (property == LightProperty::OuterCone) light.outer_cone_rad = value.x;
}

/// A bound of the values between all keys. The tangents of a spline add at most 4/27 of their length.
glm::dvec4 largest_value(const LightTrack& track) {
  const bool is_cubic = track.interpolation == Interpolation::CubicSpline;
  const std::size_t parts = is_cubic ? 3 : 1;
  glm::dvec4 result(track.values[is_cubic ? 1 : 0]);
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

void add_track(const LightTrack& track, AnimatedLight& to) {
  to.length_s = std::max(to.length_s, double{track.keys_s.back()});
  if (is_constant(track))
    set_value(track.property, glm::dvec4(first_value(track)), to.rest);
  else
    to.tracks.push_back(track);
}

/// A light without the property: a range of a directional light.
bool has_property(const Light& light, LightProperty property) {
  return property != LightProperty::Range || light.type != "directional";
}

}  // namespace

LightValues values_of(const Light& light) {
  LightValues values{.color = vector_of(light.color, glm::dvec3(1.0)),
                     .intensity = light.intensity,
                     .inner_cone_rad = light.spot.innerConeAngle,
                     .outer_cone_rad = light.spot.outerConeAngle,
                     .range_m = {}};
  if (light.range > 0) values.range_m = light.range;  // tinygltf writes 0 for a light without a range
  return values;
}

AnimatedLights animated_lights(const Document& document, const std::vector<Index>& scene_node) {
  std::set<std::uint32_t> used;
  for (std::size_t node = 0; node < scene_node.size(); ++node)
    if (const Index light = light_of(document.nodes[node]); light && scene_node[node]) used.insert(*light);
  AnimatedLights lights;
  std::set<std::pair<std::uint32_t, LightProperty>> taken;
  for (std::size_t a = 0; a < document.animations.size(); ++a)
    for (const LightChannel& from : document.light_channels[a]) {
      const LightProperty property = property_from(from.property);
      const Light& light = document.lights[from.light];
      if (!used.contains(from.light) || !has_property(light, property) ||
          !taken.emplace(from.light, property).second)
        continue;
      AnimatedLight& to = lights.try_emplace(from.light, AnimatedLight{values_of(light), {}}).first->second;
      add_track(track_from(document, document.animations[a].samplers[from.sampler], property), to);
    }
  return lights;
}

LightSource light_from(const Light& from, const LightValues& rest, const std::vector<LightTrack>& tracks,
                       std::uint32_t node) {
  LightSource to;
  to.name = from.name;
  to.node = node;
  to.kind = from.type == "point"  ? LightKind::Point
            : from.type == "spot" ? LightKind::Spot
                                  : LightKind::Directional;
  if (!tracks.empty())
    to.animation = {glm::vec3(glm::min(rest.color, kMostIntensity)),
                    static_cast<float>(std::min(rest.intensity, kMostIntensity)), 1, tracks};
  LightValues largest = rest;
  for (const LightTrack& track : tracks) set_value(track.property, largest_value(track), largest);
  to.intensity = glm::vec3(glm::min(largest.color * largest.intensity, kMostIntensity));
  if (largest.range_m && *largest.range_m < kMostRange_m && to.kind != LightKind::Directional)
    to.range_m = static_cast<float>(*largest.range_m);
  if (to.kind != LightKind::Spot) return to;
  to.inner_cone_rad = static_cast<float>(rest.inner_cone_rad);
  to.outer_cone_rad = static_cast<float>(std::min(largest.outer_cone_rad, std::numbers::pi / 2));
  return to;
}

}  // namespace farshade::gltf
