/// The glTF 2.0 loader: a file of foreign bytes in, a checked Scene or one sentence about what is wrong out.
///
/// Understood: .gltf and .glb; external, embedded and GLB buffers; PNG and JPEG; indexed and non-indexed
/// triangles, strips and fans; sparse accessors; KHR_mesh_quantization, KHR_texture_transform,
/// KHR_lights_punctual; TRS animation. Refused: every other required extension, skins, and morph targets that
/// are in use.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "stereo/scene/scene.h"

namespace farshade {

/// What a scene may cost before it is refused. The defaults hold every scene this project was tried with.
struct SceneLimits {
  std::uint64_t file_bytes = std::uint64_t{1} << 30;      ///< the scene file itself; never above 2^31
  std::uint64_t external_bytes = std::uint64_t{2} << 30;  ///< all files it names together
  std::uint64_t image_pixels = std::uint64_t{1} << 26;    ///< one image
  std::uint32_t json_depth = 128;
  std::uint32_t node_depth = 256;
  std::uint32_t lights = 256;  ///< as many as a mask has bits for
};

/// Loads a .gltf or .glb file. Files that it names are opened only inside of its own folder.
[[nodiscard]] Expected<Scene> load_scene(const std::filesystem::path& path, const SceneLimits& limits = {});

/// As load_scene, for a file that is already in memory. An empty `folder` opens no further files.
[[nodiscard]] Expected<Scene> load_scene_from_memory(std::span<const std::byte> file,
                                                     const std::filesystem::path& folder = {},
                                                     const SceneLimits& limits = {});

}  // namespace farshade
