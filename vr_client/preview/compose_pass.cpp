#include "vr_client/preview/compose_pass.h"

#include <array>

#include "shaders/anaglyph.frag.spv.h"
#include "shaders/anaglyph.vert.spv.h"
#include "shaders/anaglyph_data.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

gpu::AnaglyphData anaglyph_data(const Composition& composition, const Panel& panel, Extent eye) {
  const auto picture = [&](std::size_t i) { return static_cast<std::uint32_t>(composition.pictures[i]); };
  return {
      .place = {panel.left, panel.top, static_cast<float>(eye.width) / static_cast<float>(panel.size.width),
                static_cast<float>(eye.height) / static_cast<float>(panel.size.height)},
      .pictures = {picture(0), picture(1), composition.shared.first[0], composition.shared.first[1]}};
}

vk::Offset3D corner(std::uint32_t x, std::uint32_t y) {
  return {narrow<std::int32_t>(x), narrow<std::int32_t>(y), 1};
}

}  // namespace

ComposePass::ComposePass(const gpu::Device& device, const gpu::Image& eyes, vk::Format format)
    : device_(device),
      eyes_(eyes),
      bindings_(gpu::make_bindings(device,
                                   {{vk::DescriptorType::eStorageImage, vk::ShaderStageFlagBits::eFragment},
                                    {vk::DescriptorType::eStorageImage, vk::ShaderStageFlagBits::eFragment}},
                                   "anaglyph")) {
  check_eq(eyes.spec.layers, std::uint32_t{kEyes}, "layers of the eyes' image");
  // Nothing is uploaded yet, but the descriptor set needs an image.
  for (const std::uint32_t binding : {0u, 1u})
    gpu::bind_image(device, bindings_, binding, {*eyes.view, Layout::eGeneral, nullptr});
  const vk::DescriptorSetLayout set = *bindings_.layout;
  const auto push = gpu::push_constants<gpu::AnaglyphData>(vk::ShaderStageFlagBits::eFragment);
  layout_ = device.logical.createPipelineLayout(
      {.setLayoutCount = 1, .pSetLayouts = &set, .pushConstantRangeCount = 1, .pPushConstantRanges = &push});
  nearest_ = make_pipeline(Filter::Nearest, format);
  linear_ = make_pipeline(Filter::Linear, format);
}

vk::raii::Pipeline ComposePass::make_pipeline(Filter filter, vk::Format format) const {
  return gpu::make_graphics_pipeline(device_, layout_,
                                     {.vertex = anaglyph_vert_spv,
                                      .fragment = anaglyph_frag_spv,
                                      .constants = {static_cast<std::uint32_t>(filter)},
                                      .colors = {format}},
                                     "anaglyph");
}

void ComposePass::make_uploads() {
  using Usage = vk::ImageUsageFlagBits;
  uploads_ = gpu::make_image(device_,
                             {.size = eyes_.spec.size,
                              .layers = kEyes,
                              .format = vk::Format::eR8G8B8A8Unorm,
                              .usage = Usage::eStorage | Usage::eTransferDst | Usage::eTransferSrc},
                             "uploads");
  staging_ = gpu::make_staging_buffer(device_, eyes_.spec.size.pixels() * 4, "uploads staging");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    constexpr auto filled = Layout::eTransferDstOptimal;
    gpu::transition(commands, uploads_, Layout::eUndefined, filled);
    commands.clearColorImage(*uploads_.image, filled, vk::ClearColorValue{},
                             vk::ImageSubresourceRange{vk::ImageAspectFlagBits::eColor, 0, 1, 0, kEyes});
    gpu::transition(commands, uploads_, filled, Layout::eGeneral);
  });
  device_.logical.waitIdle();  // a frame in flight may use the descriptor set
  gpu::bind_image(device_, bindings_, 1, {*uploads_.view, Layout::eGeneral, nullptr});
}

void ComposePass::upload(Side side, const Image<Rgb8>& picture) {
  check(picture.size == eyes_.spec.size, "an upload has the size of the eyes");
  if (uploads_.spec.size.pixels() == 0) make_uploads();
  staging_.view<Rgba8>()
      .part(0, picture.pixels.size())
      .generate([from = picture.pixels.data()](std::size_t i) { return Rgba8(from[i], 255); });
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    const gpu::LayerRange layer{static_cast<std::uint32_t>(index_of(side)), 1};
    constexpr auto filled = Layout::eTransferDstOptimal;
    gpu::transition(commands, uploads_, Layout::eGeneral, filled, layer);
    commands.copyBufferToImage(
        *staging_.buffer, *uploads_.image, filled,
        vk::BufferImageCopy{.imageSubresource = {vk::ImageAspectFlagBits::eColor, 0, layer.first, 1},
                            .imageExtent = {eyes_.spec.size.width, eyes_.spec.size.height, 1}});
    gpu::transition(commands, uploads_, filled, Layout::eGeneral, layer);
  });
}

/// At equal sizes the blit does not filter: the window gets the bytes of the picture.
void ComposePass::copy(const vk::raii::CommandBuffer& commands, Picture picture, const Panel& panel,
                       vk::Image target) const {
  const auto number = static_cast<std::uint32_t>(picture);
  const gpu::Image& source = number < kEyes ? eyes_ : uploads_;
  const Extent size = eyes_.spec.size;
  check(source.spec.size == size, "a picture that replaces an eye was uploaded");
  const gpu::LayerRange layer{number % std::uint32_t{kEyes}, 1};
  const vk::ImageBlit blit{
      .srcSubresource = {vk::ImageAspectFlagBits::eColor, 0, layer.first, 1},
      .srcOffsets = {{vk::Offset3D{}, corner(size.width, size.height)}},
      .dstSubresource = {vk::ImageAspectFlagBits::eColor, 0, 0, 1},
      .dstOffsets = {{vk::Offset3D{narrow<std::int32_t>(panel.left), narrow<std::int32_t>(panel.top), 0},
                      corner(panel.left + panel.size.width, panel.top + panel.size.height)}}};
  gpu::transition(commands, source, Layout::eGeneral, Layout::eTransferSrcOptimal, layer);
  commands.blitImage(*source.image, Layout::eTransferSrcOptimal, target, Layout::eTransferDstOptimal, blit,
                     panel.size == size ? vk::Filter::eNearest : vk::Filter::eLinear);
  gpu::transition(commands, source, Layout::eTransferSrcOptimal, Layout::eGeneral, layer);
}

void ComposePass::draw_anaglyph(const vk::raii::CommandBuffer& commands, const Composition& composition,
                                const Panel& panel, Extent eye, const ComposeTarget& target) const {
  gpu::transition(commands, target.image, Layout::eTransferDstOptimal, Layout::eColorAttachmentOptimal);
  const vk::RenderingAttachmentInfo color{.imageView = target.view,
                                          .imageLayout = Layout::eColorAttachmentOptimal,
                                          .loadOp = vk::AttachmentLoadOp::eLoad,
                                          .storeOp = vk::AttachmentStoreOp::eStore};
  const vk::Rect2D place{{narrow<std::int32_t>(panel.left), narrow<std::int32_t>(panel.top)},
                         {panel.size.width, panel.size.height}};
  commands.beginRendering(
      {.renderArea = place, .layerCount = 1, .colorAttachmentCount = 1, .pColorAttachments = &color});
  commands.setViewport(0, vk::Viewport{.width = static_cast<float>(target.size.width),
                                       .height = static_cast<float>(target.size.height),
                                       .maxDepth = 1});
  commands.setScissor(0, place);
  commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout_, 0, *bindings_.set, {});
  commands.bindPipeline(vk::PipelineBindPoint::eGraphics, panel.size == eye ? *nearest_ : *linear_);
  commands.pushConstants<gpu::AnaglyphData>(*layout_, vk::ShaderStageFlagBits::eFragment, 0,
                                            anaglyph_data(composition, panel, eye));
  commands.draw(3, 1, 0, 0);
  commands.endRendering();
  gpu::transition(commands, target.image, Layout::eColorAttachmentOptimal, Layout::eTransferDstOptimal);
}

void ComposePass::record(const vk::raii::CommandBuffer& commands, const Composition& composition,
                         const ComposeTarget& target) const {
  gpu::transition(commands, target.image, Layout::eUndefined, Layout::eTransferDstOptimal);
  commands.clearColorImage(target.image, Layout::eTransferDstOptimal,
                           vk::ClearColorValue(std::array{0.0f, 0.0f, 0.0f, 1.0f}),
                           vk::ImageSubresourceRange{vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1});
  const vk::MemoryBarrier2 in_order{
      .srcStageMask = vk::PipelineStageFlagBits2::eAllCommands,
      .srcAccessMask = vk::AccessFlagBits2::eMemoryWrite,
      .dstStageMask = vk::PipelineStageFlagBits2::eAllCommands,
      .dstAccessMask = vk::AccessFlagBits2::eMemoryRead | vk::AccessFlagBits2::eMemoryWrite};
  commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &in_order});
  const auto [eye, aspect] = shown_part(composition, eyes_.spec.size);
  for (const Panel& panel :
       panel_rects(left_of(target.size, composition.right_px), eye, aspect, composition.layout))
    if (composition.layout == StereoLayout::Anaglyph)
      draw_anaglyph(commands, composition, panel, eye, target);
    else
      copy(commands, composition.pictures[panel.eye], panel, target.image);
}

}  // namespace farshade
