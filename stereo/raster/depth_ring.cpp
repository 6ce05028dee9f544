#include "stereo/raster/depth_ring.h"

#include <algorithm>

#include "stereo/gpu/device.h"
#include "stereo/raster/scene_pass.h"

namespace farshade {

DepthRing::DepthRing(const gpu::Device& device, Extent size, std::uint32_t slots)
    : image_(gpu::make_image(
          device,
          {.size = size,
           .layers = static_cast<std::uint32_t>(kEyes) * (slots + 1),
           .format = kDepthFormat,
           .usage = vk::ImageUsageFlagBits::eDepthStencilAttachment | vk::ImageUsageFlagBits::eTransferSrc |
                    vk::ImageUsageFlagBits::eTransferDst | vk::ImageUsageFlagBits::eSampled,
           .use = gpu::Use::Depth},
          "depth ring")),
      slots_(slots + 1) {
  for (std::uint32_t i = 0; i < slots_.size(); ++i)
    slots_[i].view = gpu::view_layers(device, image_, {static_cast<std::uint32_t>(i * kEyes), kEyes});
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, image_, vk::ImageLayout::eUndefined, vk::ImageLayout::eShaderReadOnlyOptimal);
  });
}

DepthRing::Place DepthRing::place(std::size_t slot) const {
  return {static_cast<std::uint32_t>(slot * kEyes), *slots_[slot].view};
}

std::optional<std::size_t> DepthRing::slot_of(FrameId frame) const {
  const auto slot = std::ranges::find(slots_, std::optional(frame), &Slot::frame);
  if (slot == slots_.end()) return std::nullopt;
  return static_cast<std::size_t>(slot - slots_.begin());
}

std::optional<DepthRing::Place> DepthRing::claim(FrameId frame, std::size_t slot) {
  if (slot + 1 >= slots_.size()) return std::nullopt;
  slots_[slot].frame = frame;
  return place(slot);
}

void DepthRing::forget() {
  for (Slot& slot : slots_) slot.frame.reset();
}

std::uint32_t DepthRing::layer_of(FrameId frame) const {
  const std::optional<std::size_t> slot = slot_of(frame);
  check(slot.has_value(), "the ring has the frame whose layer is read");
  return place(*slot).layer;
}

}  // namespace farshade
