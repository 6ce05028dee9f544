/// Buffers and images with their memory. Each has one allocation, except textures, which share a few. The
/// type of a buffer says who writes it: the host never reads what it writes (StagingBuffer), and never writes
/// what it reads (ReadbackBuffer). All other buffers and images are in device-local memory.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/base/extent.h"
#include "stereo/base/write_only.h"
#include "stereo/gpu/device.h"

namespace farshade::gpu {

struct Buffer {
  Charge charge;
  vk::raii::DeviceMemory memory{nullptr};
  vk::raii::Buffer buffer{nullptr};
  std::size_t bytes = 0;
};

/// A buffer whose memory is mapped and coherent.
struct MappedBuffer {
  Buffer buffer;
  std::byte* bytes = nullptr;
};

/// Host memory from which the device copies to other buffers and images.
class StagingBuffer : public Buffer {
 public:
  StagingBuffer() = default;
  explicit StagingBuffer(MappedBuffer mapped) : Buffer(std::move(mapped.buffer)), mapped_(mapped.bytes) {}

  template <class T>
  [[nodiscard]] WriteOnly<T> view() const {
    return WriteOnly<std::byte>(std::span(mapped_, bytes)).as<T>();
  }

 private:
  std::byte* mapped_ = nullptr;
};

/// Written by the device, read by the host.
class ReadbackBuffer : public Buffer {
 public:
  ReadbackBuffer() = default;
  explicit ReadbackBuffer(MappedBuffer mapped) : Buffer(std::move(mapped.buffer)), mapped_(mapped.bytes) {}

  template <class T>
  [[nodiscard]] std::span<const T> as() const {
    return {reinterpret_cast<const T*>(mapped_), bytes / sizeof(T)};
  }

 private:
  const std::byte* mapped_ = nullptr;
};

// All functions below throw when the device has no memory or no allocation left. If a type of memory has none
// left, they try the next one that fits. A size below 16 bytes is rounded up to 16.

[[nodiscard]] StagingBuffer make_staging_buffer(const Device& device, std::size_t bytes,
                                                const std::string& name, Use use = Use::Staging);

/// `usage`: eTransferDst for copies, eStorageBuffer for what shaders write.
[[nodiscard]] ReadbackBuffer make_readback_buffer(const Device& device, std::size_t bytes,
                                                  vk::BufferUsageFlags usage, const std::string& name,
                                                  Use use = Use::ReadBack);

/// Written and read by the device only.
[[nodiscard]] Buffer make_device_buffer(const Device& device, std::size_t bytes, vk::BufferUsageFlags usage,
                                        const std::string& name, Use use = Use::Other);

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
  vk::raii::DeviceMemory memory{nullptr};  ///< null for an image of an ImageGroup
  vk::raii::Image image{nullptr};
  vk::raii::ImageView view{nullptr};  ///< all layers as an array, all mip levels
  ImageSpec spec;
  vk::ImageAspectFlags aspect;
};

[[nodiscard]] Image make_image(const Device& device, const ImageSpec& spec, const std::string& name);

struct LayerRange {
  std::uint32_t first = 0, count = VK_REMAINING_ARRAY_LAYERS;
};
[[nodiscard]] vk::raii::ImageView view_layers(const Device& device, const Image& image, LayerRange layers);

/// Changes the layout of layers. Its barrier makes earlier writes visible to later commands.
void transition(const vk::raii::CommandBuffer& commands, const Image& image, vk::ImageLayout from,
                vk::ImageLayout to, LayerRange layers = {});

/// The same for the layers of an image that is not an Image, such as a swapchain's. It has one mip level.
void transition(const vk::raii::CommandBuffer& commands, vk::Image image, vk::ImageLayout from,
                vk::ImageLayout to, LayerRange layers = {},
                vk::ImageAspectFlags aspect = vk::ImageAspectFlagBits::eColor);

/// The host sees the copies recorded before, once their fence is signalled. A fence alone does not ensure it.
void show_copies_to_host(const vk::raii::CommandBuffer& commands);

/// A memory allocation that several images share.
struct Allocation {
  Charge charge;
  vk::raii::DeviceMemory memory{nullptr};
};
/// The bytes of an allocation that images share are at most this, or those of one image.
inline constexpr std::size_t kSharedBytes = 64 << 20;

/// Images without contents that share allocations.
struct ImageGroup {
  std::vector<Allocation> memory;
  std::vector<Image> images;  ///< one for each spec
};
/// `specs` have the same use, format and usage flags.
[[nodiscard]] ImageGroup make_image_group(const Device& device, std::span<const ImageSpec> specs,
                                          const std::string& name);

}  // namespace farshade::gpu
