/// The graphics pipelines of ScenePass: what they write, and for which meshes they are specialised.
#pragma once

#include <compare>
#include <map>

#include "stereo/gpu/pass.h"
#include "stereo/plan/plan_masks.h"

namespace farshade {

inline constexpr vk::Format kColorFormat = vk::Format::eR8G8B8A8Srgb, kDepthFormat = vk::Format::eD32Sfloat;

/// The G-buffer keeps the instance of each pixel: some instance can move, and masks are reprojected.
[[nodiscard]] bool keeps_instances(const DrawPlan& plan);

/// Shading normals and, if masks are reprojected, geometric normals and instances.
[[nodiscard]] constexpr vk::Format surface_format(const DrawPlan& plan) {
  return reprojects_masks(plan) ? vk::Format::eR32G32Uint : vk::Format::eR32Uint;
}

/// What a scene pass writes.
enum class Outputs : std::uint8_t {
  GBuffer,  ///< base colours, surfaces, depth
  Depth,    ///< depth only: no normals, no colours; textures only for alpha tests
  Casters,  ///< depth of both sides of every surface, for shadow maps
};
[[nodiscard]] const char* to_string(Outputs outputs);

/// What the mesh that a pipeline draws needs.
struct SceneVariant {
  bool textured = false, masked = false, colored = false;
  friend auto operator<=>(const SceneVariant&, const SceneVariant&) = default;
};
[[nodiscard]] SceneVariant variant_for(const SurfaceNeeds& needs, Outputs outputs);

/// Those that passes with the same outputs share.
using ScenePipelines = std::map<SceneVariant, vk::raii::Pipeline>;

/// The pipeline binds these vertex streams, in this order: positions; normals, if it writes a G-buffer;
/// texture coordinates, if it is textured; colours, if it is coloured. Viewport, scissor, cull mode and front
/// face are dynamic.
[[nodiscard]] vk::raii::Pipeline make_scene_pipeline(const gpu::Device& device,
                                                     const vk::raii::PipelineLayout& layout,
                                                     const DrawPlan& plan, Outputs outputs,
                                                     SceneVariant variant);

/// The pipeline of HiddenPass for a scene pass with these outputs: sets the depth of what it covers. It binds
/// one stream, of corners. Viewport and scissor are dynamic. `layout` has the push constants of hidden.vert.
[[nodiscard]] vk::raii::Pipeline make_hidden_pipeline(const gpu::Device& device,
                                                      const vk::raii::PipelineLayout& layout,
                                                      const DrawPlan& plan, Outputs outputs);

}  // namespace farshade
