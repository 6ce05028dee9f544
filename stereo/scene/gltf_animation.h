/// Converts the animation channels of a validated Document.
#pragma once

#include "stereo/scene/gltf_deform.h"
#include "stereo/scene/gltf_document.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

/// Sets Scene::channels, Scene::animation_length_s and Node::moving. `scene_node` maps nodes of the document
/// to nodes of the scene. All animations play at the same time; if two animate the same property, the first
/// one wins. A channel with a constant value becomes part of the node's rest transform. Returns the
/// weights of morph targets.
WeightTracks add_animations(const Document& document, const std::vector<Index>& scene_node, Scene& scene);

}  // namespace farshade::gltf
