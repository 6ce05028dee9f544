/// Runs the frames of a client, and goes on after a loss of its device.
#pragma once

#include "vr_client/frame/frame_loop.h"

namespace farshade {

/// The device of a run, and how to open it again.
struct FrameDevice {
  std::function<RunContext()> context;  ///< of a run on the open device
  /// Destroys everything that was made on the device, and leaves the device itself.
  std::function<void()> clear;
  /// Opens a device again in place of the lost one, and makes on it what `clear` has destroyed. Empty: it
  /// cannot be opened again.
  std::function<Expected<void>()> reopen = {};
};

/// A device that is lost again before it has shown so many frames is lost in a row (gpu::DeviceLosses).
inline constexpr std::uint32_t kEnoughFrames = 100;

/// Shows frames as `run` does, with the pipeline of the context's mode. If the device is lost
/// (vk::DeviceLostError), warns, opens it again and goes on with the next frame: frames count on, and the
/// session with the server stays. The pipeline is a new one, and so knows no mask whose depth is lost.
/// Unavailable, with the cure, if the device is lost for good; then it has been cleared.
[[nodiscard]] Expected<void> run_frames(const FrameDevice& device, const FrameWatcher& watch,
                                        const std::function<bool()>& stop);

}  // namespace farshade
