#include "vr_client/draw/renderer.h"

namespace farshade {
namespace {

std::uint32_t light_count(const Scene& scene) {
  return narrow<std::uint32_t>(scene.lights.size());
}

}  // namespace

Renderer::Renderer(const gpu::Device& device, const Scene& scene, Extent size, std::uint32_t depth_frames)
    : device_(device),
      size_(size),
      gbuffer_(device, scene, size, depth_frames),
      shading_(device, gbuffer_, size, light_count(scene)),
      commands_(std::move(device.logical.allocateCommandBuffers({.commandPool = *device.commands,
                                                                 .level = vk::CommandBufferLevel::ePrimary,
                                                                 .commandBufferCount = 1})[0])),
      fence_(device.logical.createFence({})),
      stamps_(device, 3),
      readback_(gpu::make_readback_buffer(device, size.pixels() * kEyes * 4, "read-back")) {}

DrawTimes Renderer::draw(const ShownFrame& frame) {
  const Stopwatch watch;
  std::vector<MaskInHand> usable;
  for (const MaskInHand& mask : frame.masks) {
    const bool drawn_over = gbuffer_.depth_layer(mask.frame) == gbuffer_.depth_layer(frame.frame);
    const bool has_depth = mask.frame == frame.frame || (gbuffer_.has_depth(mask.frame) && !drawn_over);
    if (has_depth && usable.size() < ShadingPass::kMaxMasks) usable.push_back(mask);
  }
  gbuffer_.prepare(frame.views, frame.state);
  shading_.prepare(frame.frame, frame.views, frame.state.light_set, usable);
  DrawTimes times = submit(frame, Stage::Both, frame.lookup);
  times.total = watch.elapsed();
  return times;
}

DrawTimes Renderer::draw_gbuffer(const ShownFrame& frame) {
  const Stopwatch watch;
  gbuffer_.prepare(frame.views, frame.state);
  shading_.prepare(frame.frame, frame.views, frame.state.light_set, {});
  DrawTimes times = submit(frame, Stage::GBuffer, frame.lookup);
  times.total = watch.elapsed();
  return times;
}

DrawTimes Renderer::shade_again(const ShownFrame& frame, const MaskInHand& reference) {
  const Stopwatch watch;
  shading_.prepare(frame.frame, frame.views, frame.state.light_set, {&reference, 1});
  DrawTimes times = submit(frame, Stage::Shade, Lookup::Direct);
  times.total = watch.elapsed();
  return times;
}

DrawTimes Renderer::submit(const ShownFrame& frame, Stage stage, Lookup lookup) {
  commands_.reset();
  commands_.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  stamps_.reset(commands_);
  stamps_.write(commands_, 0);
  if (stage != Stage::Shade) gbuffer_.record(commands_, frame.frame);
  stamps_.write(commands_, 1);
  if (stage != Stage::GBuffer) shading_.record(commands_, lookup, frame.report);
  stamps_.write(commands_, 2);
  commands_.end();
  gpu::submit_and_wait(device_, commands_, fence_);
  return {.gbuffer = stamps_.between(0, 1), .shade = stamps_.between(1, 2)};
}

PerEye<Image<Rgb8>> Renderer::read_shown() const {
  read_back(shading_.shown(), vk::ImageLayout::eGeneral, {0, kEyes});
  const auto pixels = readback_.as<const Rgba8>();
  PerEye<Image<Rgb8>> result{Image<Rgb8>(size_), Image<Rgb8>(size_)};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t i = 0; i < size_.pixels(); ++i)
      result[eye].pixels[i] = Rgb8(pixels[eye * size_.pixels() + i]);
  return result;
}

PerEye<Image<float>> Renderer::read_distance(FrameId frame) const {
  check(gbuffer_.has_depth(frame), "the depth asked for is in the ring");
  read_back(gbuffer_.depth_ring(), vk::ImageLayout::eShaderReadOnlyOptimal,
            {gbuffer_.depth_layer(frame), kEyes});
  const auto depths = readback_.as<const float>();
  PerEye<Image<float>> result{Image<float>(size_), Image<float>(size_)};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t i = 0; i < size_.pixels(); ++i)
      if (const float depth = depths[eye * size_.pixels() + i]; depth > 0)
        result[eye].pixels[i] = static_cast<float>(kNearPlane_m / depth);
  return result;
}

/// Layers of an image that rests in `layout`, four bytes a pixel, into `readback_`.
void Renderer::read_back(const gpu::Image& image, vk::ImageLayout layout, gpu::LayerRange layers) const {
  constexpr auto source = vk::ImageLayout::eTransferSrcOptimal;
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, image, layout, source, layers);
    commands.copyImageToBuffer(
        *image.image, source, *readback_.buffer,
        vk::BufferImageCopy{.imageSubresource = {image.aspect, 0, layers.first, layers.count},
                            .imageExtent = {size_.width, size_.height, 1}});
    gpu::transition(commands, image, source, layout, layers);
  });
}

}  // namespace farshade
