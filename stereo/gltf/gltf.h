/// The glTF 2.0 loader. It turns an untrusted file into a checked Scene, or into one sentence about why
/// nothing can be drawn. Faults that leave something to draw are repaired (docs/files.md): Scene::warnings
/// has a sentence for each kind, which begins with "repaired: ".
///
/// Supported: .gltf and .glb; external, embedded and GLB buffers; PNG, JPEG and EXT_texture_webp; indexed and
/// non-indexed triangles, strips and fans; sparse accessors; KHR_mesh_quantization, EXT_meshopt_compression,
/// KHR_draco_mesh_compression; EXT_mesh_gpu_instancing; KHR_texture_transform, KHR_materials_variants,
/// KHR_lights_punctual, KHR_node_visibility; KHR_animation_pointer to nodes and lights; animation of
/// translation, rotation, scale and weights; skins and morph targets. What else changes the picture is left
/// out with one warning a kind (Scene::warnings; docs/limits.md). Refused: every other required extension.
#pragma once

#include <cstddef>
#include <span>

#include "stereo/scene/scene.h"
#include "stereo/scene/scene_choice.h"

namespace farshade {

/// Limits above which a scene is refused.
struct SceneLimits {
  std::uint64_t file_bytes = std::uint64_t{1} << 30;      ///< the scene file itself; never above 2^31
  std::uint64_t external_bytes = std::uint64_t{2} << 30;  ///< all external files together
  std::uint64_t image_pixels = std::uint64_t{1} << 26;    ///< one image
  /// All images together, 4 bytes each. They may also have no more than image_pixels and 16 for each byte of
  /// their files. An image of one colour has up to 64 (JPEG) or 8,000 (PNG) pixels a byte, one with content
  /// less than 16; image_pixels leave room for some of one colour.
  std::uint64_t all_image_pixels = std::uint64_t{1} << 30;
  std::uint32_t json_depth = 128;
  std::uint32_t node_depth = 256;
  std::uint32_t lights = 256;  ///< the number of bits that a mask can have
};

/// Whether the loader hashes the files that it reads and lists them (Scene::files), for a server that sends
/// them.
enum class ListFiles : std::uint8_t { No, Yes };

/// Loads a .gltf or .glb file. It may name external files only inside its own folder.
[[nodiscard]] Expected<Scene> load_scene(const std::filesystem::path& path, const SceneLimits& limits = {},
                                         const SceneChoice& choice = {}, ListFiles list = ListFiles::No);

/// As load_scene, for a file in memory. With an empty `folder`, external files cannot be read.
[[nodiscard]] Expected<Scene> load_scene_from_memory(std::span<const std::byte> file,
                                                     const std::filesystem::path& folder = {},
                                                     const SceneLimits& limits = {},
                                                     const SceneChoice& choice = {},
                                                     ListFiles list = ListFiles::No);

}  // namespace farshade
