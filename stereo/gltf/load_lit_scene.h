/// Loads a glTF file and lights it: what the programs do with the file that they are given.
#pragma once

#include <filesystem>

#include "stereo/gltf/gltf.h"
#include "stereo/scene/lighting.h"

namespace farshade {

/// Loads a glTF file (gltf.h) and lights it.
[[nodiscard]] Expected<LitScene> load_lit_scene(const std::filesystem::path& path, const Lighting& lighting,
                                                ListFiles list = ListFiles::No);

}  // namespace farshade
