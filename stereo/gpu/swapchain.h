/// Swapchain: the images of a window, recreated when the size of the window changes. Drawing has its own
/// pace, so the swapchain never waits for the display: it prefers MAILBOX and IMMEDIATE, and `acquire` does
/// not wait for an image. The images are 8-bit UNORM and contain sRGB-coded colours.
#pragma once

#include <optional>

#include "stereo/gpu/memory.h"

namespace farshade::gpu {

class Swapchain {
 public:
  /// Keeps both references. Throws if the surface supports no 8-bit UNORM format.
  Swapchain(const Device& device, const vk::raii::SurfaceKHR& surface);

  /// Recreates the swapchain if its size is not `requested` or it no longer fits the surface. Returns whether
  /// it did; then targets and size have changed, acquired images are gone, and the device is idle. No fence
  /// of `acquire` may be pending. With an extent of zero there are no images.
  [[nodiscard]] bool fit(Extent requested);

  /// The size of the images as granted by the surface; zero if there are no images.
  [[nodiscard]] Extent size() const { return size_; }
  [[nodiscard]] vk::Format format() const { return format_.format; }
  /// An image to draw to or copy to.
  struct Target {
    vk::Image image;
    vk::raii::ImageView view;
  };
  [[nodiscard]] const std::vector<Target>& targets() const { return targets_; }

  /// The index of the next image to draw to; signals `ready` when drawing may begin. Empty if no image is
  /// free, or if the swapchain no longer fits (the next `fit` recreates it). A fence, because a queue that
  /// waited for a semaphore of the display would hold up all later work.
  [[nodiscard]] std::optional<std::uint32_t> acquire(vk::Fence ready);

  /// Presents image `index` once `drawn` is signalled.
  void present(std::uint32_t index, vk::Semaphore drawn);

 private:
  const Device& device_;
  const vk::raii::SurfaceKHR& surface_;
  vk::SurfaceFormatKHR format_;
  vk::PresentModeKHR mode_;
  Extent requested_, size_;
  enum class State : std::uint8_t { Fits, Stale } state_ = State::Stale;
  vk::raii::SwapchainKHR swapchain_{nullptr};
  std::vector<Target> targets_;
};

}  // namespace farshade::gpu
