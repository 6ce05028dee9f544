/// The scene on the device: a vertex stream only where a material reads it, textures with their samplers.
#pragma once

#include <vector>

#include "stereo/gpu/pass.h"
#include "stereo/scene/scene.h"

namespace farshade {

struct MeshBuffers {
  gpu::Buffer positions, normals, uvs, colors, indices;  ///< uvs and colors are empty where the mesh has none
  std::uint32_t index_count = 0;
  glm::vec3 low{0.0f}, high{0.0f};  ///< object-space box
};

struct TextureBuffers {
  gpu::Image image;
  vk::raii::Sampler sampler{nullptr};
  gpu::Bindings bindings;  ///< set 1 of the G-buffer pass
};

struct SceneBuffers {
  std::vector<MeshBuffers> meshes;
  std::vector<TextureBuffers> textures;
  vk::raii::DescriptorSetLayout texture_layout{nullptr};
};

[[nodiscard]] SceneBuffers make_scene_buffers(const gpu::Device& device, const Scene& scene);

}  // namespace farshade
