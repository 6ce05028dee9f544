/// The content hash by which client and server see that they speak of the same scene.
#pragma once

#include "stereo/scene/scene.h"

namespace farshade {

/// BLAKE2b-256 over everything the picture depends on: geometry, looks, decoded textures, nodes, lights,
/// motion and camera; not names, not what is derived from these. Field by field, little-endian, lists with
/// their length first.
[[nodiscard]] SceneHash hash_of(const Scene& scene);

}  // namespace farshade
