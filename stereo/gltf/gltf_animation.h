/// Converts the lights of a validated Document, and the channels that animate its nodes, the weights of its
/// morph targets, and its lights (KHR_animation_pointer).
#pragma once

#include <map>

#include "stereo/gltf/gltf_model.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

/// The animated weights of morph targets, by the document's nodes.
using WeightTracks = std::map<int, WeightTrack>;

/// Weights beyond this are cut off.
inline constexpr double kMostWeight = 1e6;

/// A light of the document. Tracks with a constant value are part of `rest`.
struct AnimatedLight {
  Light rest;
  std::vector<LightTrack> tracks;
};

/// What moves besides nodes. The lights are those of the document.
struct Moving {
  WeightTracks weights;
  std::vector<AnimatedLight> lights;
};

/// Where a track has its first value: a cubic spline has a tangent of `width` numbers before it.
template <class Track>
[[nodiscard]] std::size_t first_value(const Track& track, std::size_t width = 1) {
  return track.interpolation == Interpolation::CubicSpline ? width : 0;
}

/// Whether a track, whose values have `width` numbers, has the same value at all times.
template <class Track>
[[nodiscard]] bool is_constant(const Track& track, std::size_t width = 1) {
  if (track.keys_s.size() == 1) return true;
  using Value = std::decay_t<decltype(track.values.front())>;
  const std::size_t first = first_value(track, width);
  for (std::size_t i = 0; i < track.values.size(); ++i) {
    const bool is_tangent = first > 0 && i / width % 3 != 1;
    if (track.values[i] != (is_tangent ? Value(0.0f) : track.values[first + i % width])) return false;
  }
  return true;
}

/// Sets Scene::channels, Scene::animation_length_s and Node::moving. `scene_node` maps nodes of the document
/// to nodes of the scene. All animations of the document play at the same time; if two animate the same
/// property, the first one wins. A channel with a constant value becomes part of the node's rest transform.
/// Of lights, only those that a node of the scene carries are animated.
[[nodiscard]] Moving add_animations(const Document& document, const std::vector<Index>& scene_node,
                                    Scene& scene);

[[nodiscard]] LightSource light_from(const AnimatedLight& from, std::uint32_t node);

}  // namespace farshade::gltf
