/// A validated Document into a Scene: the default scene's nodes, parents first, and what hangs on them.
#pragma once

#include "stereo/scene/gltf.h"
#include "stereo/scene/gltf_document.h"

namespace farshade::gltf {

/// Refuses images that cannot be decoded, scenes without triangles, more lights than the limit, and what lies
/// more than 1e9 m from the origin. Leaves name and hash empty.
[[nodiscard]] Expected<Scene> convert(const Document& document, const SceneLimits& limits);

}  // namespace farshade::gltf
