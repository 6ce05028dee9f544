/// Buffers and images with their memory. Each has one allocation, except textures, which share a few. The
/// type of a buffer says who writes it: the host never reads what it writes (UploadBuffer, StagingBuffer),
/// and never writes what it reads (ReadbackBuffer). All other buffers and images are in device-local memory.
#pragma once

#include <cstddef>
#include <initializer_list>
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

/// Written by the host every frame, read by the device. Either both use one memory, or the device copies what
/// was written (Uploads): record_uploads must come before the commands that read.
class UploadBuffer {
 public:
  UploadBuffer() = default;
  explicit UploadBuffer(StagingBuffer shared) : host_(std::move(shared)) {}
  /// `device` is a transfer destination of the same size.
  UploadBuffer(Buffer device, StagingBuffer host) : device_(std::move(device)), host_(std::move(host)) {}

  /// What the device reads.
  [[nodiscard]] const Buffer& buffer() const { return is_staged() ? device_ : host_; }
  [[nodiscard]] std::size_t bytes() const { return host_.bytes; }

  /// All elements, or some of them.
  template <class T>
  [[nodiscard]] WriteOnly<T> view() {
    return view<T>(0, bytes() / sizeof(T));
  }
  template <class T>
  [[nodiscard]] WriteOnly<T> view(std::size_t first, std::size_t count) {
    const WriteOnly<T> part = host_.view<T>().part(first, count);
    if (is_staged() && count > 0) will_copy(first * sizeof(T), count * sizeof(T));
    return part;
  }
  template <class T>
  void write(std::size_t i, const T& value) {
    view<T>(i, 1).write(0, value);
  }

 private:
  friend void record_uploads(const vk::raii::CommandBuffer& commands,
                             std::span<const UploadBuffer* const> buffers);
  [[nodiscard]] bool is_staged() const { return device_.bytes > 0; }
  void will_copy(std::size_t first, std::size_t count);

  Buffer device_;  ///< without bytes: the device reads what the host writes
  StagingBuffer host_;
  /// What views were made of since it was copied last. Mutable: recording a copy changes no content.
  mutable std::vector<vk::BufferCopy> written_;
};

/// Copies to the device what was written to staged buffers since the last call. All commands after it read
/// the new content, and all before it the old one. Not within a rendering.
void record_uploads(const vk::raii::CommandBuffer& commands, std::span<const UploadBuffer* const> buffers);
inline void record_uploads(const vk::raii::CommandBuffer& commands,
                           std::initializer_list<const UploadBuffer*> buffers) {
  record_uploads(commands, std::span(buffers.begin(), buffers.size()));
}

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
// left, they try the next one that fits.

/// A size below 16 bytes is rounded up to 16.
[[nodiscard]] UploadBuffer make_upload_buffer(const Device& device, std::size_t bytes,
                                              vk::BufferUsageFlags usage, const std::string& name,
                                              Use use = Use::Other);

[[nodiscard]] StagingBuffer make_staging_buffer(const Device& device, std::size_t bytes,
                                                const std::string& name);

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
