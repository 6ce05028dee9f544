/// Converts the lights of a validated Document, and what animations change in them (KHR_animation_pointer).
#pragma once

#include <map>

#include "stereo/scene/gltf_document.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

/// A light of the document. Tracks with a constant value are part of `rest`.
struct AnimatedLight {
  Light rest;
  std::vector<LightTrack> tracks;
  double length_s = 0;  ///< of all tracks, also of the constant ones
};

/// The lights that animations change, by their number in the document, and of these only lights that a node
/// of the scene carries. If two animations change the same property, the first one wins.
using AnimatedLights = std::map<std::uint32_t, AnimatedLight>;
[[nodiscard]] AnimatedLights animated_lights(const Document& document, const std::vector<Index>& scene_node);

/// `tracks` may be empty.
[[nodiscard]] LightSource light_from(const Light& from, const std::vector<LightTrack>& tracks,
                                     std::uint32_t node);

}  // namespace farshade::gltf
