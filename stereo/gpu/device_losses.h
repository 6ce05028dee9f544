/// DeviceLosses: whether a device that is lost (vk::DeviceLostError) is opened again or given up.
#pragma once

#include <cstdint>

namespace farshade::gpu {

class DeviceLosses {
 public:
  /// A device that is lost so many times in a row is given up.
  static constexpr int kMost = 3;

  /// Losses are in a row if the device has finished fewer than `enough` pieces of work between them.
  explicit DeviceLosses(std::uint32_t enough) : enough_(enough) {}

  /// The device has finished a piece of work.
  void add_work() {
    if (++work_ >= enough_) losses_ = 0;
  }
  /// The device is lost. Returns whether it is given up.
  [[nodiscard]] bool add_loss() {
    work_ = 0;
    return ++losses_ >= kMost;
  }

 private:
  std::uint32_t enough_, work_ = 0;  ///< work since the last loss
  int losses_ = 0;                   ///< in a row
};

}  // namespace farshade::gpu
