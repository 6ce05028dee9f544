/// FrameCommands: what a frame asks of the device. A frame is recorded in parts, one command buffer each, and
/// goes to the device in one submission, without Device::timelines in one for each part. Nothing waits for
/// the device but `wait`, which can wait for the first parts of a frame while the device still works on the
/// others (docs/gpu.md).
#pragma once

#include <vector>

#include "stereo/gpu/device.h"

namespace farshade::gpu {

/// What is recorded next begins when everything before it has finished: frames and parts use the same images
/// and buffers.
void wait_for_earlier(const vk::raii::CommandBuffer& commands);

class FrameCommands {
 public:
  /// Parts count from 1 on, over all frames; 0 is a part that has always finished.
  using Part = std::uint64_t;

  /// Keeps the reference.
  explicit FrameCommands(const Device& device);
  FrameCommands(const FrameCommands&) = delete;
  FrameCommands& operator=(const FrameCommands&) = delete;
  /// Waits for the device.
  ~FrameCommands();

  /// Calls `record` with the command buffer of a new part. The device begins a part when it has finished all
  /// earlier ones, and sees what they wrote.
  Part record(const Recording& record);

  /// Submits all parts that have been recorded since, if there are any. Does not wait.
  void submit();

  /// Waits until the device has finished `part`; submits it first if it must. Any failure is reported as
  /// vk::DeviceLostError, as by submit_and_wait.
  void wait(Part part);

  /// The newest part that was recorded, and the newest that was submitted.
  [[nodiscard]] Part newest() const { return newest_; }
  [[nodiscard]] Part submitted() const { return submitted_; }

 private:
  struct Buffer {
    vk::raii::CommandBuffer commands;
    vk::raii::Fence fence{nullptr};  ///< of devices without timelines
    Part part = 0;
  };
  [[nodiscard]] Buffer& free_buffer();
  [[nodiscard]] std::vector<const Buffer*> recorded() const;
  void submit_together();
  void submit_apart();
  [[nodiscard]] bool finishes(Part part) const;

  const Device& device_;
  std::vector<Buffer> buffers_;                  ///< grows as needed
  vk::raii::Semaphore finished_{nullptr};        ///< a timeline: the newest part that has finished
  Part newest_ = 0, submitted_ = 0, known_ = 0;  ///< known_: has finished
  bool is_lost_ = false;
};

}  // namespace farshade::gpu
