#include "vr_client/draw/depth_ring.h"

#include "stereo/gpu/device.h"
#include "vr_client/draw/scene_pass.h"

namespace farshade {

DepthRing::DepthRing(const gpu::Device& device, Extent size, std::uint32_t frames)
    : image_(
          gpu::make_image(device,
                          {.size = size,
                           .layers = static_cast<std::uint32_t>(kEyes) * (frames + 1),
                           .format = kDepthFormat,
                           .usage = vk::ImageUsageFlagBits::eDepthStencilAttachment |
                                    vk::ImageUsageFlagBits::eTransferSrc | vk::ImageUsageFlagBits::eSampled},
                          "depth ring")),
      slots_(frames + 1) {
  for (std::uint32_t i = 0; i < slots_.size(); ++i)
    slots_[i].view = gpu::view_layers(device, image_, i * kEyes, kEyes);
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, image_, vk::ImageLayout::eUndefined, vk::ImageLayout::eShaderReadOnlyOptimal);
  });
}

DepthRing::Place DepthRing::place(std::size_t slot) const {
  return {static_cast<std::uint32_t>(slot * kEyes), *slots_[slot].view};
}

DepthRing::Place DepthRing::claim(FrameId frame) {
  slots_[slot_of(frame)].frame = frame;
  return place(slot_of(frame));
}

std::uint32_t DepthRing::layer_of(FrameId frame) const {
  check(has(frame), "the depth asked for is in the ring");
  return place(slot_of(frame)).layer;
}

}  // namespace farshade
