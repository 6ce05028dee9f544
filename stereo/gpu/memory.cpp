#include "stereo/gpu/memory.h"

#include <algorithm>
#include <stdexcept>

namespace farshade::gpu {
namespace {

using Property = vk::MemoryPropertyFlagBits;

/// Memory types with other properties need a feature, or are for special images.
constexpr vk::MemoryPropertyFlags kPlain =
    Property::eDeviceLocal | Property::eHostVisible | Property::eHostCoherent | Property::eHostCached;

/// The memory types that have all properties of `choices[0]`, then those of `choices[1]`, and so on.
std::vector<std::uint32_t> memory_types(const Device& device, std::uint32_t allowed,
                                        std::initializer_list<vk::MemoryPropertyFlags> choices) {
  std::vector<std::uint32_t> types;
  for (const vk::MemoryPropertyFlags required : choices)
    for (std::uint32_t i = 0; i < device.memory.memoryTypeCount; ++i) {
      const vk::MemoryPropertyFlags offered = device.memory.memoryTypes[i].propertyFlags;
      const bool is_new = std::ranges::find(types, i) == types.end();
      if ((allowed >> i & 1u) && (offered & required) == required && !(offered & ~kPlain) && is_new)
        types.push_back(i);
    }
  return types;
}

/// What makes a buffer or image smaller.
std::string cure(Use use) {
  switch (use) {
    case Use::Vertices:
    case Use::Textures:
      return "a smaller scene needs less";
    case Use::Frame:
    case Use::Motion:
      return "a scene with fewer instances needs less";
    case Use::ShadowMaps:
      return "smaller shadow maps (--shadow-maps) need less";
    case Use::EdgeRays:
      return "--edges line needs none";
    case Use::Report:
      return "a run without comparison (--reference-every 0) needs none, fewer pixels an eye (--size) need "
             "less";
    default:
      return "fewer pixels an eye (--size, --xr-scale) need less";
  }
}

/// Refuses `wanted` with the device's limit: the call that would fail, what the device allows, and the cure.
[[noreturn]] void refuse(const Device& device, const char* call, const std::string& name, Use use,
                         const std::string& allowed) {
  throw std::runtime_error(std::string(call) + " for '" + name + "': " + device.name + " allows " + allowed +
                           ": " + cure(use));
}

constexpr std::uint64_t kMiB = 1 << 20;

/// "LIMIT where, and NEEDED are needed", rounded so that the numbers differ.
std::string mebibytes(std::uint64_t limit, std::uint64_t needed, const char* where) {
  return std::to_string(limit / kMiB) + " MiB " + where + ", and " +
         std::to_string((needed + kMiB - 1) / kMiB) + " MiB are needed";
}

/// In the first of `types` that has the memory.
Allocation allocate(const Device& device, std::size_t bytes, const std::vector<std::uint32_t>& types,
                    const std::string& name, Use use) {
  constexpr const char* kCall = "vkAllocateMemory";
  if (device.ledger->read().allocations >= device.max_allocations)
    refuse(device, kCall, name, use,
           std::to_string(device.max_allocations) + " allocations, and all are in use");
  if (bytes > device.max_allocation_bytes)
    refuse(device, kCall, name, use, mebibytes(device.max_allocation_bytes, bytes, "in one allocation"));
  for (const std::uint32_t type : types) try {
      Allocation result;
      result.memory = device.logical.allocateMemory({.allocationSize = bytes, .memoryTypeIndex = type});
      result.charge = Charge(device.ledger, use, bytes);
      return result;
    } catch (const vk::OutOfDeviceMemoryError&) {
    }
  throw vk::OutOfDeviceMemoryError(std::string(kCall) + " for '" + name + "': " + device.name + " has no " +
                                   std::to_string((bytes + kMiB - 1) / kMiB) + " MiB left: " + cure(use));
}

Buffer make_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                   std::initializer_list<vk::MemoryPropertyFlags> memory, const std::string& name, Use use) {
  Buffer result;
  result.bytes = std::max<std::size_t>(bytes, 16);
  if ((usage & vk::BufferUsageFlagBits::eStorageBuffer) && result.bytes > device.max_storage_bytes)
    refuse(device, "vkCreateBuffer", name, use,
           mebibytes(device.max_storage_bytes, result.bytes, "in one storage buffer"));
  result.buffer = device.logical.createBuffer({.size = result.bytes, .usage = usage});
  const vk::MemoryRequirements needs = result.buffer.getMemoryRequirements();
  Allocation allocation =
      allocate(device, needs.size, memory_types(device, needs.memoryTypeBits, memory), name, use);
  result.memory = std::move(allocation.memory);
  result.charge = std::move(allocation.charge);
  result.buffer.bindMemory(*result.memory, 0);
  set_name(device, result.buffer, name);
  return result;
}

MappedBuffer mapped(Buffer buffer) {
  auto* const bytes = static_cast<std::byte*>(buffer.memory.mapMemory(0, VK_WHOLE_SIZE));
  return {std::move(buffer), bytes};
}

constexpr vk::MemoryPropertyFlags kHost = Property::eHostVisible | Property::eHostCoherent;

vk::ImageAspectFlags aspect_of(vk::Format format) {
  return format == vk::Format::eD32Sfloat ? vk::ImageAspectFlagBits::eDepth : vk::ImageAspectFlagBits::eColor;
}

/// Bytes of all levels and layers, without padding.
std::uint64_t least_bytes(const ImageSpec& spec) {
  std::uint64_t pixels = 0;
  for (std::uint32_t mip = 0; mip < spec.mip_levels; ++mip)
    pixels += std::uint64_t{std::max(spec.size.width >> mip, 1u)} * std::max(spec.size.height >> mip, 1u);
  return pixels * spec.layers * pixel_bytes(spec.format);
}

/// Throws if the image is larger than the device allows.
void check_limits(const Device& device, const ImageSpec& spec, const std::string& name) {
  const auto refused = [&](const std::string& allowed) {
    refuse(device, "vkCreateImage", name, spec.use, allowed);
  };
  const auto limits = device.image_limits(device.physical, spec.format, spec.usage);
  if (!limits) refused("no " + vk::to_string(spec.format) + " as " + vk::to_string(spec.usage));
  const std::uint32_t side = std::max(spec.size.width, spec.size.height),
                      most = std::min(
                          {device.max_image_side_px, limits->maxExtent.width, limits->maxExtent.height}),
                      layers = std::min(device.max_image_layers, limits->maxArrayLayers);
  if (side > most)
    refused(std::to_string(most) + " pixels a side, and " + std::to_string(side) + " are needed");
  if (spec.layers > layers)
    refused(std::to_string(layers) + " layers, and " + std::to_string(spec.layers) + " are needed");
  if (least_bytes(spec) > limits->maxResourceSize)
    refused(mebibytes(limits->maxResourceSize, least_bytes(spec), "in one image"));
}

/// An image without memory and view. Throws if it is larger than the device allows.
Image bare_image(const Device& device, const ImageSpec& spec, const std::string& name) {
  check_limits(device, spec, name);
  Image result;
  result.spec = spec;
  result.aspect = aspect_of(spec.format);
  result.image = device.logical.createImage({.imageType = vk::ImageType::e2D,
                                             .format = spec.format,
                                             .extent = {spec.size.width, spec.size.height, 1},
                                             .mipLevels = spec.mip_levels,
                                             .arrayLayers = spec.layers,
                                             .samples = vk::SampleCountFlagBits::e1,
                                             .usage = spec.usage});
  set_name(device, result.image, name);
  return result;
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

/// Binds `images` one after the other to one allocation.
Allocation bind_together(const Device& device, std::span<Image> images, const std::string& name) {
  std::size_t bytes = 0;
  std::uint32_t allowed = ~0u;
  std::vector<std::size_t> offsets;
  for (const Image& image : images) {
    const vk::MemoryRequirements needs = image.image.getMemoryRequirements();
    bytes = (bytes + needs.alignment - 1) / needs.alignment * needs.alignment;
    offsets.push_back(bytes);
    bytes += needs.size;
    allowed &= needs.memoryTypeBits;
  }
  Allocation result = allocate(device, bytes, memory_types(device, allowed, {Property::eDeviceLocal, {}}),
                               name, images[0].spec.use);
  for (std::size_t i = 0; i < images.size(); ++i) images[i].image.bindMemory(*result.memory, offsets[i]);
  return result;
}

}  // namespace

vk::raii::ImageView view_layers(const Device& device, const Image& image, LayerRange layers) {
  return device.logical.createImageView({.image = *image.image,
                                         .viewType = vk::ImageViewType::e2DArray,
                                         .format = image.spec.format,
                                         .subresourceRange = {.aspectMask = image.aspect,
                                                              .levelCount = image.spec.mip_levels,
                                                              .baseArrayLayer = layers.first,
                                                              .layerCount = layers.count}});
}

StagingBuffer make_staging_buffer(const Device& device, std::size_t bytes, const std::string& name, Use use) {
  return StagingBuffer(
      mapped(make_buffer(device, bytes, vk::BufferUsageFlagBits::eTransferSrc, {kHost}, name, use)));
}

ReadbackBuffer make_readback_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                                    const std::string& name, Use use) {
  return ReadbackBuffer(
      mapped(make_buffer(device, bytes, usage, {kHost | Property::eHostCached, kHost}, name, use)));
}

Buffer make_device_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                          const std::string& name, Use use) {
  return make_buffer(device, bytes, usage, {Property::eDeviceLocal, {}}, name, use);
}

Image make_image(const Device& device, const ImageSpec& spec, const std::string& name) {
  Image result = bare_image(device, spec, name);
  Allocation allocation = bind_together(device, {&result, 1}, name);
  result.memory = std::move(allocation.memory);
  result.charge = std::move(allocation.charge);
  result.view = view_layers(device, result, {0, spec.layers});
  return result;
}

ImageGroup make_image_group(const Device& device, std::span<const ImageSpec> specs, const std::string& name) {
  ImageGroup group;
  std::vector<std::size_t> first{0};  // image of each allocation
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < specs.size(); ++i) {
    group.images.push_back(bare_image(device, specs[i], name + " " + std::to_string(i)));
    const std::size_t needed = group.images[i].image.getMemoryRequirements().size;
    if (bytes > 0 && bytes + needed > kSharedBytes) {
      first.push_back(i);
      bytes = 0;
    }
    bytes += needed;
  }
  first.push_back(specs.size());
  const std::span<Image> images(group.images);
  for (std::size_t i = 0; i + 1 < first.size() && !specs.empty(); ++i)
    group.memory.push_back(
        bind_together(device, images.subspan(first[i], first[i + 1] - first[i]), name + " memory"));
  for (Image& image : group.images) image.view = view_layers(device, image, {0, image.spec.layers});
  return group;
}

void transition(const vk::raii::CommandBuffer& commands, const Image& image, vk::ImageLayout from,
                vk::ImageLayout to, LayerRange layers) {
  barrier(commands, *image.image, from, to,
          {image.aspect, 0, VK_REMAINING_MIP_LEVELS, layers.first, layers.count});
}

void transition(const vk::raii::CommandBuffer& commands, vk::Image image, vk::ImageLayout from,
                vk::ImageLayout to, LayerRange layers, vk::ImageAspectFlags aspect) {
  barrier(commands, image, from, to, {aspect, 0, 1, layers.first, layers.count});
}

void show_copies_to_host(const vk::raii::CommandBuffer& commands) {
  const vk::MemoryBarrier2 visible{.srcStageMask = vk::PipelineStageFlagBits2::eTransfer,
                                   .srcAccessMask = vk::AccessFlagBits2::eTransferWrite,
                                   .dstStageMask = vk::PipelineStageFlagBits2::eHost,
                                   .dstAccessMask = vk::AccessFlagBits2::eHostRead};
  commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &visible});
}

}  // namespace farshade::gpu
