/// Converts the default scene of a validated Document: its nodes, parents first, with their meshes and
/// lights.
#pragma once

#include "stereo/gltf/gltf.h"
#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// Refuses scenes without triangles, more lights than the limit, and geometry further than 1e9 m from the
/// origin. Does not set name and hash.
[[nodiscard]] Expected<Scene> convert(Document& document, const SceneLimits& limits);

}  // namespace farshade::gltf
