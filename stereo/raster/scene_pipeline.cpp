#include "stereo/raster/scene_pipeline.h"

#include <algorithm>
#include <array>

#include "shaders/depth.frag.spv.h"
#include "shaders/depth.vert.spv.h"
#include "shaders/depth_color.frag.spv.h"
#include "shaders/depth_color.vert.spv.h"
#include "shaders/depth_uv.frag.spv.h"
#include "shaders/depth_uv.vert.spv.h"
#include "shaders/depth_uv_color.frag.spv.h"
#include "shaders/depth_uv_color.vert.spv.h"
#include "shaders/gbuffer.frag.spv.h"
#include "shaders/gbuffer.vert.spv.h"
#include "shaders/gbuffer_color.frag.spv.h"
#include "shaders/gbuffer_color.vert.spv.h"
#include "shaders/gbuffer_uv.frag.spv.h"
#include "shaders/gbuffer_uv.vert.spv.h"
#include "shaders/gbuffer_uv_color.frag.spv.h"
#include "shaders/gbuffer_uv_color.vert.spv.h"
#include "shaders/hidden.vert.spv.h"

namespace farshade {
namespace {

using Words = std::span<const std::uint32_t>;
struct Shaders {
  Words vertex, fragment;
};

Shaders shaders_of(Outputs outputs, bool textured, bool colored) {
  const std::array gbuffer{Shaders{gbuffer_vert_spv, gbuffer_frag_spv},
                           Shaders{gbuffer_uv_vert_spv, gbuffer_uv_frag_spv},
                           Shaders{gbuffer_color_vert_spv, gbuffer_color_frag_spv},
                           Shaders{gbuffer_uv_color_vert_spv, gbuffer_uv_color_frag_spv}};
  const std::array depth{Shaders{depth_vert_spv, depth_frag_spv},
                         Shaders{depth_uv_vert_spv, depth_uv_frag_spv},
                         Shaders{depth_color_vert_spv, depth_color_frag_spv},
                         Shaders{depth_uv_color_vert_spv, depth_uv_color_frag_spv}};
  const std::size_t streams = (textured ? 1u : 0u) + (colored ? 2u : 0u);
  return outputs == Outputs::GBuffer ? gbuffer[streams] : depth[streams];
}

/// The vertex streams that a pipeline reads.
std::vector<gpu::VertexStream> streams_of(Outputs outputs, SceneVariant variant) {
  std::vector<gpu::VertexStream> streams{{0, vk::Format::eR32G32B32Sfloat, sizeof(glm::vec3)}};
  if (outputs == Outputs::GBuffer) streams.push_back({1, vk::Format::eR16G16Snorm, 2 * sizeof(std::int16_t)});
  if (variant.textured) streams.push_back({2, vk::Format::eR32G32Sfloat, sizeof(glm::vec2)});
  if (variant.colored) streams.push_back({3, vk::Format::eR8G8B8A8Unorm, sizeof(glm::u8vec4)});
  return streams;
}

std::vector<vk::Format> color_formats(Outputs outputs, const DrawPlan& plan) {
  if (outputs != Outputs::GBuffer) return {};
  return {kColorFormat, surface_format(plan)};
}

}  // namespace

bool keeps_instances(const DrawPlan& plan) {
  return reprojects_masks(plan) && std::ranges::find(plan.moves, true) != plan.moves.end();
}

const char* to_string(Outputs outputs) {
  switch (outputs) {
    case Outputs::Depth:
      return "depth";
    case Outputs::Casters:
      return "casters";
    default:
      return "G-buffer";
  }
}

SceneVariant variant_for(const SurfaceNeeds& needs, Outputs outputs) {
  const bool reads_color = needs.alpha_test || outputs == Outputs::GBuffer;
  return {reads_color && needs.texture, needs.alpha_test, reads_color && needs.vertex_color};
}

vk::raii::Pipeline make_scene_pipeline(const gpu::Device& device, const vk::raii::PipelineLayout& layout,
                                       const DrawPlan& plan, Outputs outputs, SceneVariant variant) {
  const Shaders shaders = shaders_of(outputs, variant.textured, variant.colored);
  // A pass without colours needs no fragment shader, unless the shader does alpha tests.
  const bool has_fragments = outputs == Outputs::GBuffer || variant.masked;
  // Depth is near / distance, so that a greater depth is nearer.
  return gpu::make_graphics_pipeline(
      device, layout,
      {.vertex = shaders.vertex,
       .fragment = has_fragments ? shaders.fragment : Words{},
       .constants = {variant.masked, reprojects_masks(plan), keeps_instances(plan)},
       .streams = streams_of(outputs, variant),
       .colors = color_formats(outputs, plan),
       .depth = kDepthFormat,
       .depth_test = vk::CompareOp::eGreater,
       .dynamic = {vk::DynamicState::eCullMode, vk::DynamicState::eFrontFace}},
      to_string(outputs));
}

vk::raii::Pipeline make_hidden_pipeline(const gpu::Device& device, const vk::raii::PipelineLayout& layout,
                                        const DrawPlan& plan, Outputs outputs) {
  return gpu::make_graphics_pipeline(device, layout,
                                     {.vertex = hidden_vert_spv,
                                      .streams = {{0, vk::Format::eR32G32Sfloat, sizeof(glm::vec2)}},
                                      .colors = color_formats(outputs, plan),
                                      .writes = gpu::GraphicsPipeline::Writes::DepthOnly,
                                      .depth = kDepthFormat,
                                      .depth_test = vk::CompareOp::eAlways},
                                     "hidden area");
}

}  // namespace farshade
