/// KHR_animation_pointer.
#pragma once

#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// Replaces the channels whose path is "pointer": a channel that points to a node becomes one of that node,
/// and one that points to a light becomes a LightChannel. All others are removed with a warning, and channels
/// without a node without one, as the specification asks.
void resolve_pointers(Document& document);

}  // namespace farshade::gltf
