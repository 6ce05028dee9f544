#include "stereo/gpu/memory.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>

namespace farshade::gpu {
namespace {

using Property = vk::MemoryPropertyFlagBits;

/// The first memory type that has all of `wanted`, trying the wishes in order.
std::uint32_t memory_type(const Device& device, std::uint32_t allowed,
                          std::initializer_list<vk::MemoryPropertyFlags> wishes) {
  for (const vk::MemoryPropertyFlags wanted : wishes)
    for (std::uint32_t i = 0; i < device.memory.memoryTypeCount; ++i)
      if ((allowed >> i & 1u) && (device.memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
  throw std::runtime_error("vkAllocateMemory: no memory type fits");
}

Buffer make_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                   std::initializer_list<vk::MemoryPropertyFlags> wishes, const std::string& name, Use use) {
  Buffer result;
  result.bytes = std::max<std::size_t>(bytes, 16);
  result.buffer = device.logical.createBuffer({.size = result.bytes, .usage = usage});
  const vk::MemoryRequirements needs = result.buffer.getMemoryRequirements();
  const std::uint32_t type = memory_type(device, needs.memoryTypeBits, wishes);
  result.memory = device.logical.allocateMemory({.allocationSize = needs.size, .memoryTypeIndex = type});
  result.charge = Charge(device.ledger, use, needs.size);
  result.buffer.bindMemory(*result.memory, 0);
  if (wishes.begin()[0] & Property::eHostVisible)
    result.mapped = static_cast<std::byte*>(result.memory.mapMemory(0, VK_WHOLE_SIZE));
  set_name(device, result.buffer, name);
  return result;
}

constexpr vk::MemoryPropertyFlags kHost = Property::eHostVisible | Property::eHostCoherent;

vk::ImageAspectFlags aspect_of(vk::Format format) {
  return format == vk::Format::eD32Sfloat ? vk::ImageAspectFlagBits::eDepth : vk::ImageAspectFlagBits::eColor;
}

vk::raii::ImageView make_view(const Device& device, const Image& image, LayerRange layers) {
  return device.logical.createImageView({.image = *image.image,
                                         .viewType = vk::ImageViewType::e2DArray,
                                         .format = image.wish.format,
                                         .subresourceRange = {.aspectMask = image.aspect,
                                                              .levelCount = image.wish.mip_levels,
                                                              .baseArrayLayer = layers.first,
                                                              .layerCount = layers.count}});
}

void barrier(const vk::raii::CommandBuffer& commands, vk::Image image, vk::ImageLayout from,
             vk::ImageLayout to, vk::ImageSubresourceRange range) {
  const vk::ImageMemoryBarrier2 all{
      .srcStageMask = vk::PipelineStageFlagBits2::eAllCommands,
      .srcAccessMask = vk::AccessFlagBits2::eMemoryWrite,
      .dstStageMask = vk::PipelineStageFlagBits2::eAllCommands,
      .dstAccessMask = vk::AccessFlagBits2::eMemoryRead | vk::AccessFlagBits2::eMemoryWrite,
      .oldLayout = from,
      .newLayout = to,
      .image = image,
      .subresourceRange = range};
  commands.pipelineBarrier2({.imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &all});
}

/// Halves level by level; each level ends readable by shaders.
void fill_mips(const vk::raii::CommandBuffer& commands, const Image& texture) {
  using Layout = vk::ImageLayout;
  const auto level = [](std::uint32_t mip) {
    return vk::ImageSubresourceRange{vk::ImageAspectFlagBits::eColor, mip, 1, 0, 1};
  };
  const auto side = [](std::uint32_t full, std::uint32_t mip) {
    return static_cast<std::int32_t>(std::max(full >> mip, 1u));
  };
  for (std::uint32_t mip = 1; mip < texture.wish.mip_levels; ++mip) {
    barrier(commands, *texture.image, Layout::eTransferDstOptimal, Layout::eTransferSrcOptimal,
            level(mip - 1));
    const auto corner = [&](std::uint32_t m) {
      return vk::Offset3D{side(texture.wish.size.width, m), side(texture.wish.size.height, m), 1};
    };
    const vk::ImageBlit blit{.srcSubresource = {vk::ImageAspectFlagBits::eColor, mip - 1, 0, 1},
                             .srcOffsets = {{vk::Offset3D{}, corner(mip - 1)}},
                             .dstSubresource = {vk::ImageAspectFlagBits::eColor, mip, 0, 1},
                             .dstOffsets = {{vk::Offset3D{}, corner(mip)}}};
    commands.blitImage(*texture.image, Layout::eTransferSrcOptimal, *texture.image,
                       Layout::eTransferDstOptimal, blit, vk::Filter::eLinear);
    barrier(commands, *texture.image, Layout::eTransferSrcOptimal, Layout::eShaderReadOnlyOptimal,
            level(mip - 1));
  }
  barrier(commands, *texture.image, Layout::eTransferDstOptimal, Layout::eShaderReadOnlyOptimal,
          level(texture.wish.mip_levels - 1));
}

}  // namespace

Buffer make_mapped_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                          const std::string& name, Use use) {
  return make_buffer(device, bytes, usage, {kHost | Property::eDeviceLocal, kHost}, name, use);
}

Buffer make_readback_buffer(const Device& device, std::size_t bytes, const std::string& name, Use use) {
  return make_buffer(device, bytes,
                     vk::BufferUsageFlagBits::eTransferDst | vk::BufferUsageFlagBits::eStorageBuffer,
                     {kHost | Property::eHostCached, kHost}, name, use);
}

Buffer make_device_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                          const std::string& name, Use use) {
  return make_buffer(device, bytes, usage, {Property::eDeviceLocal}, name, use);
}

Buffer make_filled_buffer(const Device& device, std::span<const std::byte> content,
                          vk::BufferUsageFlags usage, const std::string& name, Use use) {
  const Buffer staging = make_buffer(device, content.size(), vk::BufferUsageFlagBits::eTransferSrc, {kHost},
                                     name + " staging", Use::Staging);
  if (!content.empty()) std::memcpy(staging.mapped, content.data(), content.size());
  Buffer result = make_buffer(device, content.size(), usage | vk::BufferUsageFlagBits::eTransferDst,
                              {Property::eDeviceLocal}, name, use);
  run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    commands.copyBuffer(*staging.buffer, *result.buffer, vk::BufferCopy{.size = result.bytes});
  });
  return result;
}

Image make_image(const Device& device, const ImageSpec& wish, const std::string& name) {
  Image result;
  result.wish = wish;
  result.aspect = aspect_of(wish.format);
  result.image = device.logical.createImage({.imageType = vk::ImageType::e2D,
                                             .format = wish.format,
                                             .extent = {wish.size.width, wish.size.height, 1},
                                             .mipLevels = wish.mip_levels,
                                             .arrayLayers = wish.layers,
                                             .samples = vk::SampleCountFlagBits::e1,
                                             .usage = wish.usage});
  const vk::MemoryRequirements needs = result.image.getMemoryRequirements();
  result.memory = device.logical.allocateMemory(
      {.allocationSize = needs.size,
       .memoryTypeIndex = memory_type(device, needs.memoryTypeBits, {Property::eDeviceLocal, {}})});
  result.charge = Charge(device.ledger, wish.use, needs.size);
  result.image.bindMemory(*result.memory, 0);
  result.view = make_view(device, result, {0, wish.layers});
  set_name(device, result.image, name);
  return result;
}

vk::raii::ImageView view_layers(const Device& device, const Image& image, std::uint32_t first,
                                std::uint32_t layers) {
  return make_view(device, image, {first, layers});
}

void transition(const vk::raii::CommandBuffer& commands, const Image& image, vk::ImageLayout from,
                vk::ImageLayout to, LayerRange layers) {
  barrier(commands, *image.image, from, to,
          {image.aspect, 0, VK_REMAINING_MIP_LEVELS, layers.first, layers.count});
}

void transition(const vk::raii::CommandBuffer& commands, vk::Image image, vk::ImageLayout from,
                vk::ImageLayout to) {
  barrier(commands, image, from, to, {vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1});
}

Image make_texture(const Device& device, Extent size, std::span<const std::byte> rgba,
                   const std::string& name) {
  check_eq(rgba.size(), size.pixels() * 4, "a texture has four bytes a pixel");
  const Buffer staging =
      make_buffer(device, rgba.size(), vk::BufferUsageFlagBits::eTransferSrc, {kHost}, name, Use::Staging);
  std::memcpy(staging.mapped, rgba.data(), rgba.size());
  using Usage = vk::ImageUsageFlagBits;
  Image result =
      make_image(device,
                 {.size = size,
                  .mip_levels = static_cast<std::uint32_t>(std::bit_width(std::max(size.width, size.height))),
                  .format = vk::Format::eR8G8B8A8Srgb,
                  .usage = Usage::eTransferDst | Usage::eTransferSrc | Usage::eSampled,
                  .use = Use::Textures},
                 name);
  run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    transition(commands, result, vk::ImageLayout::eUndefined, vk::ImageLayout::eTransferDstOptimal);
    commands.copyBufferToImage(
        *staging.buffer, *result.image, vk::ImageLayout::eTransferDstOptimal,
        vk::BufferImageCopy{.imageSubresource = {vk::ImageAspectFlagBits::eColor, 0, 0, 1},
                            .imageExtent = {size.width, size.height, 1}});
    fill_mips(commands, result);
  });
  return result;
}

}  // namespace farshade::gpu
