#include "vr_client/preview/compose_pass.h"

#include <array>

#include "shaders/compose.frag.spv.h"
#include "shaders/compose.vert.spv.h"
#include "shaders/compose_data.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

gpu::ComposeData compose_data(const Panel& panel, const Composition& composition, Extent eye) {
  const auto picture = [&](std::size_t i) { return static_cast<std::uint32_t>(composition.pictures[i]); };
  return {
      .place = {panel.left, panel.top, static_cast<float>(eye.width) / static_cast<float>(panel.size.width),
                static_cast<float>(eye.height) / static_cast<float>(panel.size.height)},
      .pictures = {picture(panel.eye), picture(1), 0, 0}};
}

}  // namespace

ComposePass::ComposePass(const gpu::Device& device, const gpu::Image& eyes,
                         const vk::raii::RenderPass& render_pass)
    : device_(device),
      size_(eyes.wish.size),
      bindings_(gpu::make_bindings(device,
                                   {{vk::DescriptorType::eStorageImage, vk::ShaderStageFlagBits::eFragment},
                                    {vk::DescriptorType::eStorageImage, vk::ShaderStageFlagBits::eFragment}},
                                   "compose")),
      vertex_(gpu::make_shader(device, compose_vert_spv, "compose.vert")),
      fragment_(gpu::make_shader(device, compose_frag_spv, "compose.frag")) {
  check_eq(eyes.wish.layers, std::uint32_t{kEyes}, "layers of what is shown");
  // Nothing is uploaded yet, and the set wants an image.
  for (const std::uint32_t binding : {0u, 1u})
    gpu::bind_image(device, bindings_, binding, {*eyes.view, Layout::eGeneral, nullptr});
  const vk::DescriptorSetLayout set = *bindings_.layout;
  const vk::PushConstantRange push{vk::ShaderStageFlagBits::eFragment, 0, sizeof(gpu::ComposeData)};
  layout_ = device.logical.createPipelineLayout(
      {.setLayoutCount = 1, .pSetLayouts = &set, .pushConstantRangeCount = 1, .pPushConstantRanges = &push});
  for (const Blend blend : {Blend::One, Blend::Anaglyph})
    for (const Filter filter : {Filter::Nearest, Filter::Linear})
      pipelines_.push_back(make_pipeline(filter, blend, render_pass));
}

vk::raii::Pipeline ComposePass::make_pipeline(Filter filter, Blend blend,
                                              const vk::raii::RenderPass& render_pass) const {
  const gpu::Specialization specialization(
      {static_cast<std::uint32_t>(filter), static_cast<std::uint32_t>(blend)});
  const vk::SpecializationInfo constants = specialization.info();
  const std::array stages{vk::PipelineShaderStageCreateInfo{
                              .stage = vk::ShaderStageFlagBits::eVertex, .module = *vertex_, .pName = "main"},
                          vk::PipelineShaderStageCreateInfo{.stage = vk::ShaderStageFlagBits::eFragment,
                                                            .module = *fragment_,
                                                            .pName = "main",
                                                            .pSpecializationInfo = &constants}};
  const vk::PipelineVertexInputStateCreateInfo vertices;
  const vk::PipelineInputAssemblyStateCreateInfo assembly{.topology = vk::PrimitiveTopology::eTriangleList};
  const vk::PipelineViewportStateCreateInfo viewports{.viewportCount = 1, .scissorCount = 1};
  const vk::PipelineRasterizationStateCreateInfo raster{.polygonMode = vk::PolygonMode::eFill,
                                                        .lineWidth = 1};
  const vk::PipelineMultisampleStateCreateInfo samples{.rasterizationSamples = vk::SampleCountFlagBits::e1};
  using Component = vk::ColorComponentFlagBits;
  const vk::PipelineColorBlendAttachmentState write{.colorWriteMask = Component::eR | Component::eG |
                                                                      Component::eB | Component::eA};
  const vk::PipelineColorBlendStateCreateInfo over{.attachmentCount = 1, .pAttachments = &write};
  const std::array dynamics{vk::DynamicState::eViewport, vk::DynamicState::eScissor};
  const vk::PipelineDynamicStateCreateInfo dynamic{.dynamicStateCount = dynamics.size(),
                                                   .pDynamicStates = dynamics.data()};
  auto pipeline = device_.logical.createGraphicsPipeline(nullptr, {.stageCount = stages.size(),
                                                                   .pStages = stages.data(),
                                                                   .pVertexInputState = &vertices,
                                                                   .pInputAssemblyState = &assembly,
                                                                   .pViewportState = &viewports,
                                                                   .pRasterizationState = &raster,
                                                                   .pMultisampleState = &samples,
                                                                   .pColorBlendState = &over,
                                                                   .pDynamicState = &dynamic,
                                                                   .layout = *layout_,
                                                                   .renderPass = *render_pass});
  gpu::set_name(device_, pipeline, "compose");
  return pipeline;
}

void ComposePass::make_uploads() {
  using Usage = vk::ImageUsageFlagBits;
  uploads_ = gpu::make_image(device_,
                             {.size = size_,
                              .layers = kEyes,
                              .format = vk::Format::eR8G8B8A8Unorm,
                              .usage = Usage::eStorage | Usage::eTransferDst},
                             "uploads");
  staging_ = gpu::make_mapped_buffer(device_, size_.pixels() * 4, vk::BufferUsageFlagBits::eTransferSrc,
                                     "uploads staging");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    constexpr auto filled = Layout::eTransferDstOptimal;
    gpu::transition(commands, uploads_, Layout::eUndefined, filled);
    commands.clearColorImage(*uploads_.image, filled, vk::ClearColorValue{},
                             vk::ImageSubresourceRange{vk::ImageAspectFlagBits::eColor, 0, 1, 0, kEyes});
    gpu::transition(commands, uploads_, filled, Layout::eGeneral);
  });
  device_.logical.waitIdle();  // a frame in flight uses the set
  gpu::bind_image(device_, bindings_, 1, {*uploads_.view, Layout::eGeneral, nullptr});
}

void ComposePass::upload(Side side, const Image<Rgb8>& picture) {
  check(picture.size == size_, "an upload has the eyes' size");
  if (uploads_.wish.size != size_) make_uploads();
  const auto pixels = staging_.as<Rgba8>();
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) pixels[i] = Rgba8(picture.pixels[i], 255);
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    const gpu::LayerRange layer{static_cast<std::uint32_t>(index_of(side)), 1};
    constexpr auto filled = Layout::eTransferDstOptimal;
    gpu::transition(commands, uploads_, Layout::eGeneral, filled, layer);
    commands.copyBufferToImage(
        *staging_.buffer, *uploads_.image, filled,
        vk::BufferImageCopy{.imageSubresource = {vk::ImageAspectFlagBits::eColor, 0, layer.first, 1},
                            .imageExtent = {size_.width, size_.height, 1}});
    gpu::transition(commands, uploads_, filled, Layout::eGeneral, layer);
  });
}

void ComposePass::record_barrier(const vk::raii::CommandBuffer& commands) const {
  using At = vk::PipelineStageFlagBits2;
  const vk::MemoryBarrier2 drawn{
      .srcStageMask = At::eComputeShader | At::eTransfer,
      .srcAccessMask = vk::AccessFlagBits2::eShaderWrite | vk::AccessFlagBits2::eTransferWrite,
      .dstStageMask = At::eFragmentShader,
      .dstAccessMask = vk::AccessFlagBits2::eShaderRead};
  commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &drawn});
}

void ComposePass::record(const vk::raii::CommandBuffer& commands, const Composition& composition,
                         Extent window) const {
  commands.setViewport(0, vk::Viewport{.width = static_cast<float>(window.width),
                                       .height = static_cast<float>(window.height),
                                       .maxDepth = 1});
  commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout_, 0, *bindings_.set, {});
  for (const Panel& panel : panel_rects(window, size_, composition.aspect, composition.way)) {
    const std::size_t filtered = panel.size == size_ ? 0 : 1;
    const std::size_t blended = composition.way == Way::Anaglyph ? 1 : 0;
    commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipelines_[blended * 2 + filtered]);
    commands.setScissor(0, vk::Rect2D{{narrow<std::int32_t>(panel.left), narrow<std::int32_t>(panel.top)},
                                      {panel.size.width, panel.size.height}});
    commands.pushConstants<gpu::ComposeData>(*layout_, vk::ShaderStageFlagBits::eFragment, 0,
                                             compose_data(panel, composition, size_));
    commands.draw(3, 1, 0, 0);
  }
}

}  // namespace farshade
