#include "stereo/raster/gbuffer.h"

#include <array>

#include "stereo/raster/max_instances.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

gpu::Image make_output(const gpu::Device& device, Extent size, vk::Format format, const std::string& name) {
  return gpu::make_image(
      device,
      {.size = size,
       .layers = kEyes,
       .format = format,
       .usage = vk::ImageUsageFlagBits::eColorAttachment | vk::ImageUsageFlagBits::eSampled |
                vk::ImageUsageFlagBits::eTransferSrc | vk::ImageUsageFlagBits::eTransferDst,
       .use = gpu::Use::GBuffer},
      name);
}

}  // namespace

GBufferPass::GBufferPass(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
                         const SceneBuffers& buffers, const gpu::UploadBuffer& frame, Extent size)
    : size_(size),
      pass_(frames, scene, plan, buffers, frame, Outputs::GBuffer),
      hidden_(frames, plan, Outputs::GBuffer),
      base_colors_(make_output(frames.device(), size, kColorFormat, "base colours")),
      surfaces_(make_output(frames.device(), size, surface_format(plan), "surfaces")) {
  check(scene.instances.size() <= kMaxInstances, "the G-buffer has an index for every instance");
  gpu::run_now(frames.device(), [&](const vk::raii::CommandBuffer& commands) {
    for (const gpu::Image* image : {&base_colors_, &surfaces_})
      gpu::transition(commands, *image, Layout::eUndefined, Layout::eShaderReadOnlyOptimal);
  });
}

void GBufferPass::record(const vk::raii::CommandBuffer& commands, const DepthPlace& place) const {
  const gpu::LayerRange layers{place.layer, kEyes};
  gpu::transition(commands, base_colors_, Layout::eUndefined, Layout::eColorAttachmentOptimal);
  gpu::transition(commands, surfaces_, Layout::eUndefined, Layout::eColorAttachmentOptimal);
  gpu::transition(commands, *place.image, Layout::eUndefined, Layout::eDepthAttachmentOptimal, layers);
  const std::array colors{cleared(*base_colors_.view, Layout::eColorAttachmentOptimal),
                          cleared(*surfaces_.view, Layout::eColorAttachmentOptimal)};
  pass_.record(commands, size_, colors, cleared(place.view, Layout::eDepthAttachmentOptimal), 0, {},
               &hidden_);
  gpu::transition(commands, base_colors_, Layout::eColorAttachmentOptimal, Layout::eShaderReadOnlyOptimal);
  gpu::transition(commands, surfaces_, Layout::eColorAttachmentOptimal, Layout::eShaderReadOnlyOptimal);
  gpu::transition(commands, *place.image, Layout::eDepthAttachmentOptimal, Layout::eShaderReadOnlyOptimal,
                  layers);
}

void DepthPass::prepare_warm_up() {
  size_ = {1, 1};
  pass_.prepare_warm_up();
  hidden_.prepare(nullptr, {});
}

void DepthPass::prepare(const StereoView& views, const SceneState& state, Detail detail,
                        const PerEye<HiddenArea>* hidden) {
  check(views[0].size == views[1].size, "both eyes of a request have one size");
  size_ = views[0].size;
  pass_.prepare(views, state, detail);
  hidden_.prepare(hidden, views);
}

void DepthPass::record(const vk::raii::CommandBuffer& commands, const DepthPlace& place) const {
  const Extent room = place.image->spec.size;
  check(size_.width <= room.width && size_.height <= room.height, "requested views fit the image");
  const gpu::LayerRange layers{place.layer, kEyes};
  gpu::transition(commands, *place.image, Layout::eUndefined, Layout::eDepthAttachmentOptimal, layers);
  pass_.record(commands, size_, {}, cleared(place.view, Layout::eDepthAttachmentOptimal), 0, {}, &hidden_);
  gpu::transition(commands, *place.image, Layout::eDepthAttachmentOptimal, Layout::eShaderReadOnlyOptimal,
                  layers);
}

}  // namespace farshade
