/// Swapchain: the images of a window, remade whenever the window's size is another. Drawing paces itself, so
/// nothing here waits for the display: where it can replace a waiting picture it does (MAILBOX, IMMEDIATE),
/// and an image that is not free yet is not waited for. The images are 8-bit UNORM: what is drawn or
/// copied is what the screen gets, already sRGB-coded.
#pragma once

#include <optional>

#include "stereo/gpu/memory.h"

namespace farshade::gpu {

class Swapchain {
 public:
  /// Keeps both references. Throws where the surface takes no 8-bit UNORM picture.
  Swapchain(const Device& device, const vk::raii::SurfaceKHR& surface);

  /// Remade if it is not for `wanted` pixels or no longer fits the surface; true if it was: targets and size
  /// are others then, and the device is idle. An extent of zero leaves nothing to show to.
  [[nodiscard]] bool fit(Extent wanted);

  /// Of its images, as the surface grants it; zero where there is nothing to show to.
  [[nodiscard]] Extent size() const { return size_; }
  [[nodiscard]] vk::Format format() const { return format_.format; }
  /// Its images, to be drawn to or copied to.
  struct Target {
    vk::Image image;
    vk::raii::ImageView view;
  };
  [[nodiscard]] const std::vector<Target>& targets() const { return targets_; }

  /// The image to draw to next; `ready` is signalled once it may be. Nothing if none is free now, or if the
  /// swapchain no longer fits (the next `fit` remakes it).
  [[nodiscard]] std::optional<std::uint32_t> acquire(vk::Semaphore ready);

  /// Shows image `index` once `drawn` is signalled.
  void present(std::uint32_t index, vk::Semaphore drawn);

 private:
  const Device& device_;
  const vk::raii::SurfaceKHR& surface_;
  vk::SurfaceFormatKHR format_;
  vk::PresentModeKHR mode_;
  Extent wanted_, size_;
  enum class State : std::uint8_t { Fits, Stale } state_ = State::Stale;
  vk::raii::SwapchainKHR swapchain_{nullptr};
  std::vector<Target> targets_;
};

}  // namespace farshade::gpu
