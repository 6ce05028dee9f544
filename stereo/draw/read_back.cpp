#include "stereo/draw/read_back.h"

namespace farshade {

void ReadBack::copy(const gpu::Image& image, vk::ImageLayout layout, std::uint32_t first_layer, Extent size) {
  constexpr auto source = vk::ImageLayout::eTransferSrcOptimal;
  const gpu::LayerRange layers{first_layer, kEyes};
  const std::size_t bytes = size.pixels() * kEyes * 4;
  if (buffer_.bytes < bytes)
    buffer_ = gpu::make_readback_buffer(device_, bytes, vk::BufferUsageFlagBits::eTransferDst, "read-back");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, image, layout, source, layers);
    commands.copyImageToBuffer(
        *image.image, source, *buffer_.buffer,
        vk::BufferImageCopy{.imageSubresource = {image.aspect, 0, layers.first, layers.count},
                            .imageExtent = {size.width, size.height, 1}});
    gpu::transition(commands, image, source, layout, layers);
    gpu::show_copies_to_host(commands);
  });
}

}  // namespace farshade
