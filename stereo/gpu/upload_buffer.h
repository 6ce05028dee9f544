/// UploadBuffer: a buffer of the device that the host writes every frame. The host writes to memory of its
/// own frame (FramesInFlight), and the device copies it from there to its own memory before it reads. So the
/// host never disturbs a frame that the device still works on, shaders read only the device's memory, and
/// the host need not see that memory.
#pragma once

#include <initializer_list>
#include <span>
#include <vector>

#include "stereo/gpu/frames_in_flight.h"

namespace farshade::gpu {

class UploadBuffer {
 public:
  UploadBuffer() = default;
  /// `device` is a transfer destination. Keeps the reference.
  UploadBuffer(FramesInFlight& frames, Buffer device) : frames_(&frames), device_(std::move(device)) {}

  /// What the device reads.
  [[nodiscard]] const Buffer& buffer() const { return device_; }
  [[nodiscard]] std::size_t bytes() const { return device_.bytes; }

  /// All elements, or some of them. The caller writes each element of the view; those it leaves out have any
  /// content. A later view of the same elements replaces an earlier one. Valid until the frame ends.
  template <class T>
  [[nodiscard]] WriteOnly<T> view() {
    return view<T>(0, bytes() / sizeof(T));
  }
  template <class T>
  [[nodiscard]] WriteOnly<T> view(std::size_t first, std::size_t count) {
    return part(first * sizeof(T), count * sizeof(T)).template as<T>();
  }
  template <class T>
  void write(std::size_t i, const T& value) {
    view<T>(i, 1).write(0, value);
  }

 private:
  friend void record_uploads(const vk::raii::CommandBuffer& commands,
                             std::span<const UploadBuffer* const> buffers);
  /// Written, and not copied yet.
  struct Written {
    std::size_t first = 0;  ///< byte of the device's buffer
    HostMemory memory;

    [[nodiscard]] std::size_t end() const { return first + memory.bytes; }
  };
  [[nodiscard]] WriteOnly<std::byte> part(std::size_t first, std::size_t bytes);
  void forget(std::size_t first, std::size_t end);
  void record_copies(const vk::raii::CommandBuffer& commands) const;

  FramesInFlight* frames_ = nullptr;
  Buffer device_;
  /// In no order, without overlaps. Mutable: recording a copy changes no content.
  mutable std::vector<Written> written_;
  mutable std::size_t end_ = 0;  ///< of all that was written
};

/// A size below 16 bytes is rounded up to 16. Throws as the functions in memory.h do.
[[nodiscard]] UploadBuffer make_upload_buffer(FramesInFlight& frames, std::size_t bytes,
                                              vk::BufferUsageFlags usage, const std::string& name,
                                              Use use = Use::Other);

/// Copies to the device what was written since the last call. All commands after it read the new content, and
/// all before it the old one. Not within a rendering. If the recording throws afterwards, the content is
/// lost.
void record_uploads(const vk::raii::CommandBuffer& commands, std::span<const UploadBuffer* const> buffers);
inline void record_uploads(const vk::raii::CommandBuffer& commands,
                           std::initializer_list<const UploadBuffer*> buffers) {
  record_uploads(commands, std::span(buffers.begin(), buffers.size()));
}

}  // namespace farshade::gpu
