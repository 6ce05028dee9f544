#include "stereo/draw/counters.h"

#include <algorithm>
#include <bit>

#include "stereo/draw/renderer.h"
#include "stereo/edge_rays/edge_ray_data.h"
#include "stereo/image/mip_levels.h"
#include "stereo/lod/level_choice.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/raster/deformed_vertices.h"
#include "stereo/raster/frame_data.h"
#include "stereo/raster/scene_buffers.h"
#include "stereo/reproject/shading_layout.h"
#include "stereo/shadow_maps/shadow_map_views.h"

namespace farshade {
namespace {

void add_scene(const Scene& scene, const DrawPlan& plan, const SceneLevels& levels, gpu::BytesByUse& memory) {
  const std::size_t streams = stream_bytes(scene, plan, levels).total();
  memory[gpu::Use::Vertices] += streams;
  std::size_t staging = std::min(streams, kStagingBytes);
  const std::vector<bool> read = textures_read(scene, plan);
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (!read[i]) continue;
    const Extent size = i < scene.textures.size() ? scene.textures[i].image.size : Extent{1, 1};
    const std::size_t bytes = mip_pixels(size) * sizeof(Rgba8);
    memory[gpu::Use::Textures] += bytes;
    staging = std::max(staging, bytes);
  }
  memory[gpu::Use::Staging] = staging;
}

}  // namespace

namespace {

std::size_t map_data_bytes(const Scene& scene) {
  return (scene.lights.size() + 1) * sizeof(gpu::ShadowMapData);
}

/// The maps, and the pass that draws them, two layers at a time.
void add_shadow_maps(const Scene& scene, const ShadowMapSettings& maps, gpu::BytesByUse& memory) {
  const MapLayers layers = map_layers(scene, maps);
  memory[gpu::Use::ShadowMaps] = layers.bytes(maps.side_px) + map_data_bytes(scene);
  memory[gpu::Use::Frame] += layers.count / 2 * scene.instances.size() * sizeof(gpu::InstanceData);
}

}  // namespace

gpu::BytesByUse client_memory(const Scene& scene, const DrawPlan& requested, const RendererLimits& limits,
                              const SceneLevels& levels, const ShadowMapSettings* maps) {
  const DrawPlan plan = settled(requested);
  const ShadingBytes shading = shading_bytes(plan, limits.size, limits.traced_size);
  const std::size_t pixels = kEyes * limits.size.pixels();
  const RequestReprojectionBytes reprojection = request_reprojection_bytes(plan, limits.traced_size);
  const std::size_t passes = plan.depth_pass ? (2 + most_cube_mask_pairs(plan)) : 1;
  using gpu::Use;
  gpu::BytesByUse memory;
  add_scene(scene, plan, levels, memory);
  memory[Use::Frame] =
      sizeof(gpu::FrameData) + shading.lights + passes * scene.instances.size() * sizeof(gpu::InstanceData);
  memory[Use::Frame] += deformed_bytes(scene, plan);
  memory[Use::GBuffer] = pixels * (4 + (reprojects_masks(plan) ? 8 : 4));
  const std::size_t depths = 1 + (reprojects_masks(plan) ? limits.depth_frames : 0);
  memory[Use::Depth] = depths * kEyes * limits.traced_size.pixels() * 4;
  if (reprojection.reprojected > 0) memory[Use::Frame] += sizeof(gpu::FrameData) + shading.lights;
  if (most_cube_mask_pairs(plan) > 0)
    memory[Use::Depth] += kEyes * face_size(limits.size).pixels() * kCubeMaskSlots * 4;
  memory[Use::Masks] = shading.all_words(plan) + shading.all_known(plan) + kEyes * reprojection.quads +
                       reprojection.reprojected + reprojection.unknown;
  memory[Use::Motion] = shading.slots + shading.motions;
  memory[Use::Lists] = shading.lists;
  memory[Use::Shown] = pixels * 4;
  memory[Use::Report] = shading.report;
  memory[Use::ReadBack] = pixels * 4;
  if (plan.edge_rays) memory[Use::EdgeRays] = kMostEdgeRayBytes + map_data_bytes(scene);
  if (maps != nullptr) add_shadow_maps(scene, *maps, memory);
  memory[Use::Uploads] =
      limits.frames *
      (memory[Use::Frame] + shading.all_words(plan) + shading.all_known(plan) + kEyes * reprojection.quads +
       memory[Use::Motion] + (maps != nullptr || plan.edge_rays ? map_data_bytes(scene) : 0));
  return memory;
}

std::uint64_t gbuffer_triangles(const Scene& scene, const DrawPlan& plan, const SceneLevels& levels,
                                const StereoView& views) {
  const SceneState state = state_at(scene, Time{});
  std::uint64_t triangles = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const std::uint32_t mesh = scene.instances[i].mesh;
    const Bounds box = bounds_of(scene.meshes[mesh].positions);
    const gpu::InstanceData data = instance_data(views, state.stage_from_object[i]);
    const MeshLevels& own = levels_of(levels, mesh);
    double px_per_unit = 0;
    std::uint64_t eyes = 0;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      if (!may_be_seen(data, eye, box)) continue;
      ++eyes;
      const double px = pixels_per_unit(glm::dmat4(data.clip_from_object[eye]), box, views[eye].size);
      px_per_unit = std::max(px_per_unit, px);
    }
    const std::uint32_t level = choose_level(own.levels, px_per_unit, plan.detail_px, 0);
    triangles += eyes * (level == 0 ? scene.meshes[mesh].triangles.size() : own.levels[level - 1].count);
  }
  return triangles;
}

std::uint64_t most_at_once(const gpu::BytesByUse& memory) {
  using gpu::Use;
  // Vertices are uploaded first. Each upload frees its staging buffer.
  const std::uint64_t vertices = memory[Use::Vertices], textures = memory[Use::Textures];
  const std::uint64_t loading = vertices + std::max(std::min<std::uint64_t>(vertices, kStagingBytes),
                                                    textures + std::min(textures, memory[Use::Staging]));
  return std::max(loading, memory.total() - memory[Use::Staging] - memory[Use::Uploads]);
}

}  // namespace farshade
