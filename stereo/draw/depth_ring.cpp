#include "stereo/draw/depth_ring.h"

#include <algorithm>

#include "stereo/draw/scene_pass.h"
#include "stereo/gpu/device.h"

namespace farshade {

DepthRing::DepthRing(const gpu::Device& device, Extent size, std::uint32_t frames)
    : image_(gpu::make_image(
          device,
          {.size = size,
           .layers = static_cast<std::uint32_t>(kEyes) * (frames + 1),
           .format = kDepthFormat,
           .usage = vk::ImageUsageFlagBits::eDepthStencilAttachment | vk::ImageUsageFlagBits::eTransferSrc |
                    vk::ImageUsageFlagBits::eTransferDst | vk::ImageUsageFlagBits::eSampled,
           .use = gpu::Use::Depth},
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

std::optional<std::size_t> DepthRing::slot_of(FrameId frame) const {
  const auto slot = std::ranges::find(slots_, std::optional(frame), &Slot::frame);
  if (slot == slots_.end()) return std::nullopt;
  return static_cast<std::size_t>(slot - slots_.begin());
}

std::size_t DepthRing::room(std::span<const FrameId> kept) const {
  std::optional<std::size_t> oldest;
  for (std::size_t slot = 0; slot + 1 < slots_.size(); ++slot) {
    const std::optional<FrameId> held = slots_[slot].frame;
    if (!held) return slot;
    const bool is_kept = std::ranges::find(kept, *held) != kept.end();
    if (!is_kept && (!oldest || is_newer(*slots_[*oldest].frame, *held))) oldest = slot;
  }
  check(oldest.has_value(), "what is kept leaves room");
  return *oldest;
}

DepthRing::Place DepthRing::claim(FrameId frame, std::span<const FrameId> kept) {
  const std::size_t slot = slot_of(frame).value_or(room(kept));
  slots_[slot].frame = frame;
  return place(slot);
}

void DepthRing::forget() {
  for (Slot& slot : slots_) slot.frame.reset();
}

std::uint32_t DepthRing::layer_of(FrameId frame) const {
  const std::optional<std::size_t> slot = slot_of(frame);
  check(slot.has_value(), "the depth asked for is in the ring");
  return place(*slot).layer;
}

}  // namespace farshade
