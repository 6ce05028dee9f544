/// FramesInFlight: the host prepares a frame while the device still works on earlier ones. Things that the
/// host writes or changes every frame exist once for each of these frames, each in the place of its frame:
/// host memory (`take`), descriptor sets, timestamps. Things that only the device writes exist once, because
/// the device runs the frames one after the other.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "stereo/gpu/memory.h"

namespace farshade::gpu {

/// A part of host memory from which the device copies.
struct HostMemory {
  std::shared_ptr<const StagingBuffer> buffer;
  std::size_t offset = 0, bytes = 0;

  [[nodiscard]] WriteOnly<std::byte> view() const { return buffer->view<std::byte>().part(offset, bytes); }
};

class FramesInFlight {
 public:
  /// `count` frames exist at one time: the one that the host prepares, and those before it that the device
  /// has not finished. With 1 the host waits for the end of each frame. Keeps the reference.
  FramesInFlight(const Device& device, std::size_t count);
  FramesInFlight(const FramesInFlight&) = delete;
  FramesInFlight& operator=(const FramesInFlight&) = delete;

  [[nodiscard]] const Device& device() const { return device_; }
  [[nodiscard]] std::size_t count() const { return frames_.size(); }
  /// The places of the frame that the host prepares and of the next one.
  [[nodiscard]] std::size_t place() const { return place_; }
  [[nodiscard]] std::size_t next_place() const { return (place_ + 1) % count(); }

  /// Begins the next frame. The device has finished the frame that had `next_place` before.
  void next();
  /// Begins the frame again. The device has finished what was recorded of it.
  void restart();

  /// Memory that the host writes in this frame, at a multiple of 16 bytes. The device may read it until it
  /// has finished the frame.
  [[nodiscard]] HostMemory take(std::size_t bytes);

  /// Makes `memory`, which was taken in this frame, larger by `bytes` if what follows it is free.
  [[nodiscard]] bool grow(HostMemory& memory, std::size_t bytes);

  /// Keeps what this frame uses until the device has finished the frame.
  void keep(std::shared_ptr<const void> used) { frames_[place_].kept.push_back(std::move(used)); }

 private:
  struct Chunk {
    std::shared_ptr<const StagingBuffer> buffer;
    std::size_t used = 0;  ///< bytes
  };
  struct Frame {
    std::vector<Chunk> chunks;
    std::vector<std::shared_ptr<const void>> kept;
  };
  void clear(Frame& frame);
  [[nodiscard]] static std::size_t bytes_of(const Frame& frame);
  [[nodiscard]] Chunk make_chunk(std::size_t bytes) const;

  const Device& device_;
  std::vector<Frame> frames_;
  std::size_t place_ = 0;
};

}  // namespace farshade::gpu
