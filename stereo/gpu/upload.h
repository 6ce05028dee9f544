/// Uploads: host data to device buffers and textures, through staging buffers.
#pragma once

#include <span>
#include <vector>

#include "stereo/gpu/memory.h"

namespace farshade::gpu {

/// Copies host data to device buffers through one staging buffer. It submits only when the staging buffer is
/// full and at `flush`, so that many small pieces cost few submissions.
class BufferUpload {
 public:
  /// `staging_bytes` > 0.
  BufferUpload(const Device& device, std::size_t staging_bytes);

  /// Copies `content` to `target`, from byte `offset` on. `target` must exist until `flush`; `content` may be
  /// freed on return.
  void write(const Buffer& target, std::size_t offset, std::span<const std::byte> content);

  /// Waits until the device has all data that was written.
  void flush();

 private:
  struct Copy {
    vk::Buffer target;
    vk::BufferCopy region;
  };
  const Device& device_;
  StagingBuffer staging_;
  std::size_t used_ = 0;  ///< bytes of the staging buffer
  std::vector<Copy> copies_;
};

/// Textures for the given sizes and numbers of mip levels: sRGB with alpha, four bytes a pixel, without
/// contents.
struct TextureSize {
  Extent largest;
  std::uint32_t mip_levels = 1;
};
[[nodiscard]] ImageGroup make_textures(const Device& device, std::span<const TextureSize> sizes);

/// Fills all mip levels of a texture: the largest one, and all others from large to small, rows from the top.
/// Afterwards its layout is ShaderReadOnlyOptimal.
void fill_texture(const Device& device, const Image& texture, std::span<const std::byte> largest,
                  std::span<const std::byte> smaller);

}  // namespace farshade::gpu
