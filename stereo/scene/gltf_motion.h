/// Animation channels of a validated Document.
#pragma once

#include "stereo/scene/gltf_document.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

/// Fills channels, animation length and Node::moving. `scene_node` maps document nodes to scene nodes. All
/// animations play at once; of two that move the same property the first wins. What never changes becomes the
/// node's rest.
void add_motion(const Document& document, const std::vector<Index>& scene_node, Scene& scene);

}  // namespace farshade::gltf
