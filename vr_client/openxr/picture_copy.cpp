#include "vr_client/openxr/picture_copy.h"

namespace farshade::openxr {

PictureCopy::PictureCopy(const gpu::Device& device, const gpu::Image& shown)
    : device_(device),
      shown_(shown),
      commands_(std::move(device.logical.allocateCommandBuffers({.commandPool = *device.commands,
                                                                 .level = vk::CommandBufferLevel::ePrimary,
                                                                 .commandBufferCount = 1})[0])),
      fence_(device.logical.createFence({})) {}

void PictureCopy::copy_to(vk::Image target) const {
  using Layout = vk::ImageLayout;
  const auto& [size, layers] = std::tie(shown_.spec.size, shown_.spec.layers);
  const vk::ImageSubresourceLayers all{vk::ImageAspectFlagBits::eColor, 0, 0, layers};
  commands_.reset();
  commands_.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  gpu::transition(commands_, shown_, Layout::eGeneral, Layout::eTransferSrcOptimal);
  gpu::transition(commands_, target, Layout::eUndefined, Layout::eTransferDstOptimal);
  commands_.copyImage(
      *shown_.image, Layout::eTransferSrcOptimal, target, Layout::eTransferDstOptimal,
      vk::ImageCopy{.srcSubresource = all, .dstSubresource = all, .extent = {size.width, size.height, 1}});
  gpu::transition(commands_, target, Layout::eTransferDstOptimal, Layout::eColorAttachmentOptimal);
  gpu::transition(commands_, shown_, Layout::eTransferSrcOptimal, Layout::eGeneral);
  commands_.end();
  gpu::submit_and_wait(device_, commands_, fence_);
}

}  // namespace farshade::openxr
