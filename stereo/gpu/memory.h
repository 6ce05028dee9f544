/// Buffers and images with the memory they lie in: one allocation each, freed with them.
/// Mapped buffers are for what changes every frame; everything else lies on the device and is filled by
/// `upload`.
#pragma once

#include <cstddef>
#include <span>

#include "stereo/base/check.h"
#include "stereo/base/extent.h"
#include "stereo/gpu/device.h"

namespace farshade::gpu {

struct Buffer {
  Charge charge;
  vk::raii::DeviceMemory memory{nullptr};
  vk::raii::Buffer buffer{nullptr};
  std::size_t bytes = 0;
  std::byte* mapped = nullptr;  ///< null for device buffers; coherent

  template <class T>
  [[nodiscard]] std::span<T> as() const {
    check(mapped != nullptr, "only mapped buffers are read and written by the host");
    return {reinterpret_cast<T*>(mapped), bytes / sizeof(T)};
  }
};

/// Written by the host each frame, read by the device. `bytes` of 0 is rounded up to something bindable.
[[nodiscard]] Buffer make_mapped_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                                        const std::string& name, Use use = Use::Other);

/// Written by the device, read by the host.
[[nodiscard]] Buffer make_readback_buffer(const Device& device, std::size_t bytes, const std::string& name,
                                          Use use = Use::ReadBack);

/// Written and read by the device alone.
[[nodiscard]] Buffer make_device_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                                        const std::string& name, Use use = Use::Other);

/// Device-local, holding `content`.
[[nodiscard]] Buffer make_filled_buffer(const Device& device, std::span<const std::byte> content,
                                        vk::BufferUsageFlags usage, const std::string& name,
                                        Use use = Use::Other);

struct ImageSpec {
  Extent size;
  std::uint32_t layers = 1;
  std::uint32_t mip_levels = 1;
  vk::Format format = vk::Format::eUndefined;
  vk::ImageUsageFlags usage;
  Use use = Use::Other;
};

struct Image {
  Charge charge;
  vk::raii::DeviceMemory memory{nullptr};
  vk::raii::Image image{nullptr};
  vk::raii::ImageView view{nullptr};  ///< all layers as an array, all mips
  ImageSpec wish;
  vk::ImageAspectFlags aspect;
};

[[nodiscard]] Image make_image(const Device& device, const ImageSpec& wish, const std::string& name);

/// A view of `layers` layers from `first` of an image.
[[nodiscard]] vk::raii::ImageView view_layers(const Device& device, const Image& image, std::uint32_t first,
                                              std::uint32_t layers);

/// Moves layers between layouts, with the barrier that makes earlier writes visible to later use.
struct LayerRange {
  std::uint32_t first = 0, count = VK_REMAINING_ARRAY_LAYERS;
};
void transition(const vk::raii::CommandBuffer& commands, const Image& image, vk::ImageLayout from,
                vk::ImageLayout to, LayerRange layers = {});

/// The same for the one colour layer of an image whose memory is another's.
void transition(const vk::raii::CommandBuffer& commands, vk::Image image, vk::ImageLayout from,
                vk::ImageLayout to);

/// An sRGB texture with its mip chain (box filter in linear light by blits).
[[nodiscard]] Image make_texture(const Device& device, Extent size, std::span<const std::byte> rgba,
                                 const std::string& name);

}  // namespace farshade::gpu
