#include "stereo/draw/counters.h"

#include <algorithm>
#include <bit>

#include "stereo/draw/renderer.h"
#include "stereo/draw/scene_buffers.h"
#include "stereo/draw/shading_layout.h"

namespace farshade {
namespace {

std::size_t mip_chain_bytes(Extent size) {
  std::size_t bytes = 0;
  for (auto level = 0u; level < std::bit_width(std::max(size.width, size.height)); ++level)
    bytes += std::size_t{std::max(size.width >> level, 1u)} * std::max(size.height >> level, 1u) * 4;
  return bytes;
}

void add_scene(const Scene& scene, const DrawPlan& plan, const SceneLevels& levels, gpu::BytesByUse& memory) {
  const std::size_t streams = stream_bytes(scene, plan, levels).total();
  memory[gpu::Use::Vertices] += streams;
  std::size_t staging = std::min(streams, kStagingBytes);
  const std::vector<bool> read = textures_read(scene, plan);
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (!read[i]) continue;
    const Extent size = i < scene.textures.size() ? scene.textures[i].image.size : Extent{1, 1};
    memory[gpu::Use::Textures] += mip_chain_bytes(size);
    staging = std::max(staging, size.pixels() * 4);
  }
  memory[gpu::Use::Staging] = staging;
}

}  // namespace

gpu::BytesByUse client_memory(const Scene& scene, const DrawPlan& requested, const RendererLimits& limits,
                              const SceneLevels& levels) {
  const DrawPlan plan = settled(requested);
  const ShadingBytes shading = shading_bytes(plan, limits.size, limits.traced_size);
  const std::size_t pixels = kEyes * limits.size.pixels(), places = most_masks(plan) * kEyes;
  const std::size_t passes = plan.depth_pass ? 2 : 1;
  using gpu::Use;
  gpu::BytesByUse memory;
  add_scene(scene, plan, levels, memory);
  memory[Use::Frame] =
      sizeof(gpu::FrameData) + shading.lights + passes * scene.instances.size() * sizeof(gpu::InstanceData);
  memory[Use::GBuffer] = pixels * (4 + (carries_masks(plan) ? 8 : 4));
  memory[Use::Depth] = kEyes * limits.traced_size.pixels() * (limits.depth_frames + 1) * 4;
  memory[Use::Masks] = places * (shading.mask + shading.known);
  memory[Use::Motion] = shading.slots + shading.motions;
  memory[Use::Lists] = shading.lists;
  memory[Use::Shown] = pixels * 4;
  memory[Use::Report] = shading.report;
  memory[Use::ReadBack] = pixels * 4;
  return memory;
}

std::uint64_t most_at_once(const gpu::BytesByUse& memory) {
  using gpu::Use;
  // Vertices are uploaded first. Each upload frees its staging buffer.
  const std::uint64_t vertices = memory[Use::Vertices], textures = memory[Use::Textures];
  const std::uint64_t loading = vertices + std::max(std::min<std::uint64_t>(vertices, kStagingBytes),
                                                    textures + std::min(textures, memory[Use::Staging]));
  return std::max(loading, memory.total() - memory[Use::Staging]);
}

}  // namespace farshade
