#include "stereo/gpu/upload.h"

#include <algorithm>

namespace farshade::gpu {

BufferUpload::BufferUpload(const Device& device, std::size_t staging_bytes)
    : device_(device), staging_(make_staging_buffer(device, staging_bytes, "buffer staging")) {}

void BufferUpload::write(const Buffer& target, std::size_t offset, std::span<const std::byte> content) {
  check(offset + content.size() <= target.bytes, "an upload fits its buffer");
  while (!content.empty()) {
    if (used_ == staging_.bytes) flush();
    const std::size_t size = std::min(content.size(), staging_.bytes - used_);
    staging_.view<std::byte>().part(used_, size).copy(content.first(size));
    copies_.push_back({*target.buffer, {.srcOffset = used_, .dstOffset = offset, .size = size}});
    used_ += size;
    offset += size;
    content = content.subspan(size);
  }
}

void BufferUpload::flush() {
  if (copies_.empty()) return;
  run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    for (const Copy& copy : copies_) commands.copyBuffer(*staging_.buffer, copy.target, copy.region);
    const vk::MemoryBarrier2 written{.srcStageMask = vk::PipelineStageFlagBits2::eTransfer,
                                     .srcAccessMask = vk::AccessFlagBits2::eTransferWrite,
                                     .dstStageMask = vk::PipelineStageFlagBits2::eAllCommands,
                                     .dstAccessMask = vk::AccessFlagBits2::eMemoryRead};
    commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &written});
  });
  copies_.clear();
  used_ = 0;
}

ImageGroup make_textures(const Device& device, std::span<const TextureSize> sizes) {
  std::vector<ImageSpec> specs;
  for (const TextureSize& size : sizes)
    specs.push_back({.size = size.largest,
                     .mip_levels = size.mip_levels,
                     .format = vk::Format::eR8G8B8A8Srgb,
                     .usage = vk::ImageUsageFlagBits::eTransferDst | vk::ImageUsageFlagBits::eSampled,
                     .use = Use::Textures});
  return make_image_group(device, specs, "texture");
}

void fill_texture(const Device& device, const Image& texture, std::span<const std::byte> largest,
                  std::span<const std::byte> smaller) {
  using Layout = vk::ImageLayout;
  const StagingBuffer staging =
      make_staging_buffer(device, largest.size() + smaller.size(), "texture staging");
  staging.view<std::byte>().copy(largest);
  staging.view<std::byte>().part(largest.size(), smaller.size()).copy(smaller);
  std::vector<vk::BufferImageCopy> copies;
  std::size_t offset = 0;
  for (std::uint32_t mip = 0; mip < texture.spec.mip_levels; ++mip) {
    const Extent size{std::max(texture.spec.size.width >> mip, 1u),
                      std::max(texture.spec.size.height >> mip, 1u)};
    copies.push_back({.bufferOffset = offset,
                      .imageSubresource = {vk::ImageAspectFlagBits::eColor, mip, 0, 1},
                      .imageExtent = {size.width, size.height, 1}});
    offset += size.pixels() * 4;
  }
  check_eq(largest.size() + smaller.size(), offset, "a texture has four bytes for each pixel of its levels");
  run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    transition(commands, texture, Layout::eUndefined, Layout::eTransferDstOptimal);
    commands.copyBufferToImage(*staging.buffer, *texture.image, Layout::eTransferDstOptimal, copies);
    transition(commands, texture, Layout::eTransferDstOptimal, Layout::eShaderReadOnlyOptimal);
  });
}

}  // namespace farshade::gpu
