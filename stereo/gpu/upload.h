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
  Buffer staging_;
  std::size_t used_ = 0;  ///< bytes of the staging buffer
  std::vector<Copy> copies_;
};

/// The first level of a texture: sRGB with alpha, rows from the top, four bytes a pixel.
struct TextureContent {
  Extent size;
  std::span<const std::byte> rgba;
};

/// Textures in layout ShaderReadOnlyOptimal with full mip chains (box filter in linear light, by blits).
[[nodiscard]] ImageGroup make_textures(const Device& device, std::span<const TextureContent> contents);

}  // namespace farshade::gpu
