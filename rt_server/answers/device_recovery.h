/// DeviceRecovery: what happens when the Vulkan device that answers are drawn on is lost. It is opened again;
/// if that does not help, the answers that need it are no longer offered.
#pragma once

#include <functional>
#include <memory>

#include "rt_server/work/request_handlers.h"
#include "stereo/base/expected.h"
#include "stereo/gpu/device_losses.h"

namespace farshade {

/// Shared by all handlers that draw on the same device.
class DeviceRecovery {
 public:
  /// After so many losses without an answer between them the device is given up.
  static constexpr int kMostLosses = gpu::DeviceLosses::kMost;

  /// `reopen` closes the device with everything made on it, and opens a device again.
  explicit DeviceRecovery(std::function<Expected<void>()> reopen) : reopen_(std::move(reopen)) {}

  /// Lets `handler` answer `job`. If the device is lost (vk::DeviceLostError), reopens it, and throws
  /// std::runtime_error: this request gets no answer, the next one does. Throws AnswersLost with all drawn
  /// answers if the device cannot be opened again, or was lost kMostLosses times in a row.
  AnswerCost answer(RequestHandler& handler, const Job& job, FramePacker& packer);

 private:
  std::function<Expected<void>()> reopen_;
  gpu::DeviceLosses losses_{1};
};

/// `handler`, called through `recovery`.
[[nodiscard]] std::unique_ptr<RequestHandler> recovering(std::unique_ptr<RequestHandler> handler,
                                                         std::shared_ptr<DeviceRecovery> recovery);

}  // namespace farshade
