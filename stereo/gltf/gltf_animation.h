/// Converts the animation channels of a validated Document.
#pragma once

#include "stereo/gltf/gltf_deform.h"
#include "stereo/gltf/gltf_lights.h"
#include "stereo/gltf/gltf_model.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

[[nodiscard]] Interpolation interpolation_from(const std::string& name);

/// The value of a Channel or LightTrack at its first key.
template <class Track>
[[nodiscard]] glm::vec4 first_value(const Track& track) {
  return track.values[track.interpolation == Interpolation::CubicSpline ? 1 : 0];
}

/// Whether a Channel or LightTrack has the same value at all times.
template <class Track>
[[nodiscard]] bool is_constant(const Track& track) {
  if (track.keys_s.size() == 1) return true;
  const glm::vec4 first = first_value(track);
  const bool is_cubic = track.interpolation == Interpolation::CubicSpline;
  for (std::size_t i = 0; i < track.values.size(); ++i)
    if (track.values[i] != (is_cubic && i % 3 != 1 ? glm::vec4(0.0f) : first)) return false;
  return true;
}

/// Sets Scene::channels, Scene::animation_length_s and Node::moving. `scene_node` maps nodes of the document
/// to nodes of the scene. All animations of the document play at the same time; if two animate the same
/// property, the first one wins. A channel with a constant value becomes part of the node's rest transform.
/// Returns the weights of morph targets.
WeightTracks add_animations(const Document& document, const std::vector<Index>& scene_node,
                            const AnimatedLights& lights, Scene& scene);

}  // namespace farshade::gltf
