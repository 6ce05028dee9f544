#include "stereo/gpu/upload.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace farshade::gpu {
namespace {

using Layout = vk::ImageLayout;

/// The largest corner of mip level `mip`.
vk::Offset3D corner_of(const Image& texture, std::uint32_t mip) {
  const auto side = [mip](std::uint32_t full) {
    return static_cast<std::int32_t>(std::max(full >> mip, 1u));
  };
  return {side(texture.spec.size.width), side(texture.spec.size.height), 1};
}

/// Fills each mip level from the one before. Afterwards shaders can read all levels.
void fill_mips(const vk::raii::CommandBuffer& commands, const Image& texture) {
  const auto make_readable = [&](Layout from, std::uint32_t mip) {
    transition_mips(commands, texture, from, Layout::eShaderReadOnlyOptimal, {mip, 1});
  };
  for (std::uint32_t mip = 1; mip < texture.spec.mip_levels; ++mip) {
    transition_mips(commands, texture, Layout::eTransferDstOptimal, Layout::eTransferSrcOptimal,
                    {mip - 1, 1});
    const vk::ImageBlit blit{.srcSubresource = {vk::ImageAspectFlagBits::eColor, mip - 1, 0, 1},
                             .srcOffsets = {{vk::Offset3D{}, corner_of(texture, mip - 1)}},
                             .dstSubresource = {vk::ImageAspectFlagBits::eColor, mip, 0, 1},
                             .dstOffsets = {{vk::Offset3D{}, corner_of(texture, mip)}}};
    commands.blitImage(*texture.image, Layout::eTransferSrcOptimal, *texture.image,
                       Layout::eTransferDstOptimal, blit, vk::Filter::eLinear);
    make_readable(Layout::eTransferSrcOptimal, mip - 1);
  }
  make_readable(Layout::eTransferDstOptimal, texture.spec.mip_levels - 1);
}

void fill_texture(const Device& device, const Image& texture, std::span<const std::byte> rgba) {
  check_eq(rgba.size(), texture.spec.size.pixels() * 4, "a texture has four bytes a pixel");
  const Buffer staging = make_staging_buffer(device, rgba.size(), "texture staging");
  std::memcpy(staging.mapped, rgba.data(), rgba.size());
  run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    transition(commands, texture, Layout::eUndefined, Layout::eTransferDstOptimal);
    commands.copyBufferToImage(
        *staging.buffer, *texture.image, Layout::eTransferDstOptimal,
        vk::BufferImageCopy{.imageSubresource = {vk::ImageAspectFlagBits::eColor, 0, 0, 1},
                            .imageExtent = {texture.spec.size.width, texture.spec.size.height, 1}});
    fill_mips(commands, texture);
  });
}

}  // namespace

BufferUpload::BufferUpload(const Device& device, std::size_t staging_bytes)
    : device_(device), staging_(make_staging_buffer(device, staging_bytes, "buffer staging")) {}

void BufferUpload::write(const Buffer& target, std::size_t offset, std::span<const std::byte> content) {
  check(offset + content.size() <= target.bytes, "an upload fits its buffer");
  while (!content.empty()) {
    if (used_ == staging_.bytes) flush();
    const std::size_t size = std::min(content.size(), staging_.bytes - used_);
    std::memcpy(staging_.mapped + used_, content.data(), size);
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

ImageGroup make_textures(const Device& device, std::span<const TextureContent> contents) {
  using Usage = vk::ImageUsageFlagBits;
  std::vector<ImageSpec> specs;
  for (const TextureContent& content : contents)
    specs.push_back({.size = content.size,
                     .mip_levels = static_cast<std::uint32_t>(
                         std::bit_width(std::max(content.size.width, content.size.height))),
                     .format = vk::Format::eR8G8B8A8Srgb,
                     .usage = Usage::eTransferDst | Usage::eTransferSrc | Usage::eSampled,
                     .use = Use::Textures});
  ImageGroup textures = make_image_group(device, specs, "texture");
  for (std::size_t i = 0; i < contents.size(); ++i)
    fill_texture(device, textures.images[i], contents[i].rgba);
  return textures;
}

}  // namespace farshade::gpu
