/// The scene on the device: the vertex streams and textures that its plan says are read, and no others.
#pragma once

#include <optional>
#include <vector>

#include "stereo/gpu/pass.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {

/// Bytes of a mesh's streams; 0 where a stream is not needed.
struct StreamBytes {
  std::size_t positions = 0, normals = 0, uvs = 0, colors = 0, indices = 0;
  [[nodiscard]] std::size_t total() const { return positions + normals + uvs + colors + indices; }
};
[[nodiscard]] StreamBytes stream_bytes(const Mesh& mesh, const SurfaceNeeds& needs);

/// What a mesh reads, into Scene::textures; one past them: a white pixel, where the plan wants a texture and
/// the mesh has none. Nothing where the plan wants none.
[[nodiscard]] std::optional<std::size_t> texture_of(const Scene& scene, const Mesh& mesh,
                                                    const SurfaceNeeds& needs);

/// Of each texture of the scene and of the white pixel after them: whether a mesh reads it.
[[nodiscard]] std::vector<bool> textures_read(const Scene& scene, const DrawPlan& plan);

struct MeshBuffers {
  gpu::Buffer positions, normals, uvs, colors, indices;  ///< empty where the mesh does not need it
  StreamBytes bytes;
  std::optional<std::size_t> texture;  ///< into SceneBuffers::textures
  std::uint32_t index_count = 0;
  glm::dvec3 center{0.0};           ///< object space: what positions and box are relative to
  glm::vec3 low{0.0f}, high{0.0f};  ///< the box about them
};

struct TextureBuffers {
  gpu::Image image;
  vk::raii::Sampler sampler{nullptr};
  gpu::Bindings bindings;  ///< set 1 of the G-buffer pass
};

struct SceneBuffers {
  std::vector<MeshBuffers> meshes;
  std::vector<TextureBuffers> textures;                   ///< as textures_read; empty where none reads it
  vk::raii::DescriptorSetLayout texture_layout{nullptr};  ///< null where nothing is textured
};

[[nodiscard]] SceneBuffers make_scene_buffers(const gpu::Device& device, const Scene& scene,
                                              const DrawPlan& plan);

}  // namespace farshade
