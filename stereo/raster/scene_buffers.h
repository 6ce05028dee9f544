/// The scene on the device: the vertex streams and textures that its plan needs, and no others. One buffer
/// holds the vertex streams of all meshes and one buffer their indices, so that the number of allocations
/// does not depend on the number of meshes (Vulkan guarantees only 4,096).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "stereo/gpu/pass.h"
#include "stereo/gpu/upload.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/raster/deformed_vertices.h"
#include "stereo/raster/mesh_streams.h"

namespace farshade {

/// The sum over all meshes.
[[nodiscard]] StreamBytes stream_bytes(const Scene& scene, const DrawPlan& plan, const SceneLevels& levels);

/// The staging buffer for vertex streams and indices is at most this large.
inline constexpr std::size_t kStagingBytes = 16 << 20;

/// The texture that a mesh reads: an index into Scene::textures, or one past its end for a white pixel, if
/// the plan needs a texture and the mesh has none. Empty if the plan needs none.
[[nodiscard]] std::optional<std::size_t> texture_of(const Scene& scene, const Mesh& mesh,
                                                    const SurfaceNeeds& needs);

/// For each texture of the scene, and the white pixel after them: whether a mesh reads it.
[[nodiscard]] std::vector<bool> textures_read(const Scene& scene, const DrawPlan& plan);

struct DeviceMesh {
  StreamBytes bytes;
  StreamBytes offsets;                 ///< of indices: in SceneBuffers::indices; of others: in its vertices
  std::optional<std::size_t> texture;  ///< index into SceneBuffers::texture_sets
  vk::IndexType index_type = vk::IndexType::eUint32;
  std::vector<IndexRange> ranges{};   ///< of the mesh itself and of its levels
  std::vector<DetailLevel> levels{};  ///< their errors
  glm::dvec3 center{0.0};             ///< object space; positions and box are relative to it
  Bounds box{};
};

struct SceneBuffers {
  gpu::Buffer vertices, indices;
  std::vector<DeviceMesh> meshes;
  std::unique_ptr<DeformedVertices> deformed;  ///< never null; passes change it
  gpu::ImageGroup textures;                    ///< those that a mesh reads
  std::vector<vk::raii::Sampler> samplers;
  std::vector<gpu::Bindings> texture_sets;  ///< set 1 of the G-buffer pass, for each entry of textures_read
  vk::raii::DescriptorSetLayout texture_layout{nullptr};  ///< null if no mesh reads a texture
};

/// `levels` are those of the scene, or empty. Keeps `frames`. Throws if the device has too little memory.
[[nodiscard]] SceneBuffers make_scene_buffers(gpu::FramesInFlight& frames, const Scene& scene,
                                              const DrawPlan& plan, const SceneLevels& levels);

}  // namespace farshade
