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
#include "stereo/plan/plan_masks.h"

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

/// The vertex streams that a pipeline reads. Each is a binding of its own.
class VertexStreams {
 public:
  VertexStreams(Outputs outputs, SceneVariant variant) {
    add(0, vk::Format::eR32G32B32Sfloat, sizeof(glm::vec3));
    if (outputs == Outputs::GBuffer) add(1, vk::Format::eR16G16Snorm, 2 * sizeof(std::int16_t));
    if (variant.textured) add(2, vk::Format::eR32G32Sfloat, sizeof(glm::vec2));
    if (variant.colored) add(3, vk::Format::eR8G8B8A8Unorm, sizeof(glm::u8vec4));
  }
  [[nodiscard]] vk::PipelineVertexInputStateCreateInfo info() const {
    return {.vertexBindingDescriptionCount = count_,
            .pVertexBindingDescriptions = bindings_.data(),
            .vertexAttributeDescriptionCount = count_,
            .pVertexAttributeDescriptions = attributes_.data()};
  }

 private:
  void add(std::uint32_t location, vk::Format format, std::uint32_t stride) {
    bindings_[count_] = {count_, stride, vk::VertexInputRate::eVertex};
    attributes_[count_] = {location, count_, format, 0};
    ++count_;
  }

  std::array<vk::VertexInputBindingDescription, 4> bindings_;
  std::array<vk::VertexInputAttributeDescription, 4> attributes_;
  std::uint32_t count_ = 0;
};

constexpr vk::PipelineInputAssemblyStateCreateInfo kTriangles{.topology =
                                                                  vk::PrimitiveTopology::eTriangleList};
constexpr vk::PipelineViewportStateCreateInfo kOneViewport{.viewportCount = 1, .scissorCount = 1};
constexpr vk::PipelineRasterizationStateCreateInfo kFilled{.polygonMode = vk::PolygonMode::eFill,
                                                           .lineWidth = 1};
constexpr vk::PipelineMultisampleStateCreateInfo kOneSample{.rasterizationSamples =
                                                                vk::SampleCountFlagBits::e1};
/// Depth is near / distance, so that a greater depth is nearer.
constexpr vk::PipelineDepthStencilStateCreateInfo kNearestWins{
    .depthTestEnable = true, .depthWriteEnable = true, .depthCompareOp = vk::CompareOp::eGreater};
constexpr vk::PipelineDepthStencilStateCreateInfo kLastWins{
    .depthTestEnable = true, .depthWriteEnable = true, .depthCompareOp = vk::CompareOp::eAlways};
constexpr std::array kDynamicStates{vk::DynamicState::eViewport, vk::DynamicState::eScissor,
                                    vk::DynamicState::eCullMode, vk::DynamicState::eFrontFace};

/// The attachments that a pipeline writes. `info` and `rendering` point into it.
struct Attachments {
  Attachments(Outputs outputs, const DrawPlan& plan)
      : color_formats{kColorFormat, surface_format(plan)}, color_count(outputs == Outputs::GBuffer ? 2 : 0) {}

  [[nodiscard]] vk::PipelineColorBlendStateCreateInfo blend() const {
    return {.attachmentCount = color_count, .pAttachments = writes.data()};
  }
  [[nodiscard]] vk::PipelineRenderingCreateInfo rendering() const {
    return {.colorAttachmentCount = color_count,
            .pColorAttachmentFormats = color_formats.data(),
            .depthAttachmentFormat = kDepthFormat};
  }

  static constexpr vk::PipelineColorBlendAttachmentState kWriteAll{
      .colorWriteMask = vk::ColorComponentFlagBits::eR | vk::ColorComponentFlagBits::eG |
                        vk::ColorComponentFlagBits::eB | vk::ColorComponentFlagBits::eA};
  std::array<vk::PipelineColorBlendAttachmentState, 2> writes{kWriteAll, kWriteAll};
  std::array<vk::Format, 2> color_formats;
  std::uint32_t color_count;
};

/// The specialisation constants of gbuffer.frag.
gpu::Specialization constants_of(const DrawPlan& plan, SceneVariant variant) {
  return gpu::Specialization({variant.masked, reprojects_masks(plan), keeps_instances(plan)});
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
  const vk::raii::ShaderModule vertex = gpu::make_shader(device, shaders.vertex, to_string(outputs)),
                               fragment = gpu::make_shader(device, shaders.fragment, to_string(outputs));
  const gpu::Specialization specialization = constants_of(plan, variant);
  const vk::SpecializationInfo constants = specialization.info();
  const std::array stages{vk::PipelineShaderStageCreateInfo{
                              .stage = vk::ShaderStageFlagBits::eVertex, .module = *vertex, .pName = "main"},
                          vk::PipelineShaderStageCreateInfo{.stage = vk::ShaderStageFlagBits::eFragment,
                                                            .module = *fragment,
                                                            .pName = "main",
                                                            .pSpecializationInfo = &constants}};
  // A pass without colours needs no fragment shader, unless the shader does alpha tests.
  const std::uint32_t stage_count = outputs == Outputs::GBuffer || variant.masked ? 2 : 1;
  const VertexStreams streams(outputs, variant);
  const vk::PipelineVertexInputStateCreateInfo vertices = streams.info();
  const Attachments attachments(outputs, plan);
  const vk::PipelineColorBlendStateCreateInfo blend = attachments.blend();
  const vk::PipelineRenderingCreateInfo rendering = attachments.rendering();
  const vk::PipelineDynamicStateCreateInfo dynamic{.dynamicStateCount = kDynamicStates.size(),
                                                   .pDynamicStates = kDynamicStates.data()};
  auto pipeline =
      device.logical.createGraphicsPipeline(device.pipelines, {.pNext = &rendering,
                                                               .stageCount = stage_count,
                                                               .pStages = stages.data(),
                                                               .pVertexInputState = &vertices,
                                                               .pInputAssemblyState = &kTriangles,
                                                               .pViewportState = &kOneViewport,
                                                               .pRasterizationState = &kFilled,
                                                               .pMultisampleState = &kOneSample,
                                                               .pDepthStencilState = &kNearestWins,
                                                               .pColorBlendState = &blend,
                                                               .pDynamicState = &dynamic,
                                                               .layout = *layout});
  gpu::set_name(device, pipeline, to_string(outputs));
  return pipeline;
}

vk::raii::Pipeline make_hidden_pipeline(const gpu::Device& device, const vk::raii::PipelineLayout& layout,
                                        const DrawPlan& plan, Outputs outputs) {
  const vk::raii::ShaderModule vertex = gpu::make_shader(device, hidden_vert_spv, "hidden area");
  const vk::PipelineShaderStageCreateInfo stage{
      .stage = vk::ShaderStageFlagBits::eVertex, .module = *vertex, .pName = "main"};
  constexpr vk::VertexInputBindingDescription stream{0, sizeof(glm::vec2), vk::VertexInputRate::eVertex};
  constexpr vk::VertexInputAttributeDescription corner{0, 0, vk::Format::eR32G32Sfloat, 0};
  const vk::PipelineVertexInputStateCreateInfo vertices{.vertexBindingDescriptionCount = 1,
                                                        .pVertexBindingDescriptions = &stream,
                                                        .vertexAttributeDescriptionCount = 1,
                                                        .pVertexAttributeDescriptions = &corner};
  Attachments attachments(outputs, plan);
  attachments.writes = {};
  const vk::PipelineColorBlendStateCreateInfo blend = attachments.blend();
  const vk::PipelineRenderingCreateInfo rendering = attachments.rendering();
  constexpr std::array dynamic_states{vk::DynamicState::eViewport, vk::DynamicState::eScissor};
  const vk::PipelineDynamicStateCreateInfo dynamic{.dynamicStateCount = dynamic_states.size(),
                                                   .pDynamicStates = dynamic_states.data()};
  auto pipeline = device.logical.createGraphicsPipeline(device.pipelines, {.pNext = &rendering,
                                                                           .stageCount = 1,
                                                                           .pStages = &stage,
                                                                           .pVertexInputState = &vertices,
                                                                           .pInputAssemblyState = &kTriangles,
                                                                           .pViewportState = &kOneViewport,
                                                                           .pRasterizationState = &kFilled,
                                                                           .pMultisampleState = &kOneSample,
                                                                           .pDepthStencilState = &kLastWins,
                                                                           .pColorBlendState = &blend,
                                                                           .pDynamicState = &dynamic,
                                                                           .layout = *layout});
  gpu::set_name(device, pipeline, "hidden area");
  return pipeline;
}

}  // namespace farshade
