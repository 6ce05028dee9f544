/// The hash of a scene. Client and server compare it to be sure that they use the same scene.
#pragma once

#include "stereo/scene/scene.h"

namespace farshade {

/// BLAKE2b-256 over everything that the picture depends on: geometry, materials, decoded textures, nodes,
/// lights, ambient light, animation and camera. It leaves out names and derived values. Fields are hashed one
/// by one, little-endian; each list starts with its length.
[[nodiscard]] SceneHash hash_of(const Scene& scene);

}  // namespace farshade
