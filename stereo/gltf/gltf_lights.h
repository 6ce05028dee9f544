/// Converts the lights of a validated Document, and what animations change in them (KHR_animation_pointer).
#pragma once

#include <map>

#include "stereo/gltf/gltf_model.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

/// The numbers of a light.
struct LightValues {
  glm::dvec3 color{1.0};
  double intensity = 1, inner_cone_rad = 0, outer_cone_rad = 0;
  std::optional<double> range_m;
};
[[nodiscard]] LightValues values_of(const Light& light);

/// A light of the document. Tracks with a constant value are part of `rest`.
struct AnimatedLight {
  LightValues rest;
  std::vector<LightTrack> tracks;
  double length_s = 0;  ///< of all tracks, also of the constant ones
};

/// The lights that animations change, by their number in the document, and of these only lights that a node
/// of the scene carries. If two animations change the same property, the first one wins.
using AnimatedLights = std::map<std::uint32_t, AnimatedLight>;
[[nodiscard]] AnimatedLights animated_lights(const Document& document, const std::vector<Index>& scene_node);

/// `tracks` may be empty.
[[nodiscard]] LightSource light_from(const Light& from, const LightValues& rest,
                                     const std::vector<LightTrack>& tracks, std::uint32_t node);

}  // namespace farshade::gltf
