#include "stereo/gpu/swapchain.h"

#include <algorithm>
#include <stdexcept>

namespace farshade::gpu {
namespace {

vk::SurfaceFormatKHR choose_format(const Device& device, const vk::raii::SurfaceKHR& surface) {
  const auto offered = device.physical.getSurfaceFormatsKHR(*surface);
  for (const vk::Format preferred : {vk::Format::eB8G8R8A8Unorm, vk::Format::eR8G8B8A8Unorm})
    for (const vk::SurfaceFormatKHR& format : offered)
      if (format.format == preferred && format.colorSpace == vk::ColorSpaceKHR::eSrgbNonlinear) return format;
  throw std::runtime_error("vkGetPhysicalDeviceSurfaceFormatsKHR: no 8-bit UNORM format with sRGB colours");
}

/// Every surface supports FIFO.
vk::PresentModeKHR choose_mode(const Device& device, const vk::raii::SurfaceKHR& surface) {
  const auto offered = device.physical.getSurfacePresentModesKHR(*surface);
  for (const vk::PresentModeKHR preferred : {vk::PresentModeKHR::eMailbox, vk::PresentModeKHR::eImmediate})
    if (std::ranges::find(offered, preferred) != offered.end()) return preferred;
  return vk::PresentModeKHR::eFifo;
}

/// The size that the surface prescribes, or `requested` within its limits if it prescribes none.
Extent granted_size(const vk::SurfaceCapabilitiesKHR& surface, Extent requested) {
  constexpr std::uint32_t free_to_choose = 0xffff'ffff;
  if (surface.currentExtent.width != free_to_choose)
    return {surface.currentExtent.width, surface.currentExtent.height};
  return {std::clamp(requested.width, surface.minImageExtent.width, surface.maxImageExtent.width),
          std::clamp(requested.height, surface.minImageExtent.height, surface.maxImageExtent.height)};
}

vk::CompositeAlphaFlagBitsKHR choose_alpha(vk::CompositeAlphaFlagsKHR offered) {
  using Alpha = vk::CompositeAlphaFlagBitsKHR;
  return offered & Alpha::eOpaque ? Alpha::eOpaque : Alpha::eInherit;
}

}  // namespace

Swapchain::Swapchain(const Device& device, const vk::raii::SurfaceKHR& surface)
    : device_(device),
      surface_(surface),
      format_(choose_format(device, surface)),
      mode_(choose_mode(device, surface)) {}

bool Swapchain::fit(Extent requested) {
  if (requested == requested_ && state_ == State::Fits) return false;
  device_.logical.waitIdle();
  requested_ = requested;
  state_ = State::Fits;
  const vk::SurfaceCapabilitiesKHR surface = device_.physical.getSurfaceCapabilitiesKHR(*surface_);
  size_ = requested.pixels() == 0 ? Extent{} : granted_size(surface, requested);
  targets_.clear();
  if (size_.pixels() == 0) return true;
  // One image is shown, one waits to be shown, one is being drawn.
  std::uint32_t count = std::max(surface.minImageCount, 3u);
  if (surface.maxImageCount > 0) count = std::min(count, surface.maxImageCount);
  const vk::raii::SwapchainKHR old = std::move(swapchain_);
  swapchain_ = device_.logical.createSwapchainKHR(
      {.surface = *surface_,
       .minImageCount = count,
       .imageFormat = format_.format,
       .imageColorSpace = format_.colorSpace,
       .imageExtent = {size_.width, size_.height},
       .imageArrayLayers = 1,
       .imageUsage = vk::ImageUsageFlagBits::eColorAttachment | vk::ImageUsageFlagBits::eTransferDst,
       .preTransform = surface.currentTransform,
       .compositeAlpha = choose_alpha(surface.supportedCompositeAlpha),
       .presentMode = mode_,
       .clipped = true,
       .oldSwapchain = *old});
  for (const auto& image : swapchain_.getImages())
    targets_.push_back(
        {vk::Image(image), device_.logical.createImageView(
                               {.image = vk::Image(image),
                                .viewType = vk::ImageViewType::e2D,
                                .format = format_.format,
                                .subresourceRange = {vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1}})});
  return true;
}

std::optional<std::uint32_t> Swapchain::acquire(vk::Fence ready) try {
  const auto [result, index] = swapchain_.acquireNextImage(0, nullptr, ready);
  if (result == vk::Result::eSuboptimalKHR) state_ = State::Stale;
  if (result == vk::Result::eNotReady || result == vk::Result::eTimeout) return std::nullopt;
  return index;
} catch (const vk::OutOfDateKHRError&) {
  state_ = State::Stale;
  return std::nullopt;
}

void Swapchain::present(std::uint32_t index, vk::Semaphore drawn) try {
  const vk::SwapchainKHR swapchain = *swapchain_;
  const vk::Result result = device_.queue.presentKHR({.waitSemaphoreCount = 1,
                                                      .pWaitSemaphores = &drawn,
                                                      .swapchainCount = 1,
                                                      .pSwapchains = &swapchain,
                                                      .pImageIndices = &index});
  if (result == vk::Result::eSuboptimalKHR) state_ = State::Stale;
} catch (const vk::OutOfDateKHRError&) {
  state_ = State::Stale;
}

}  // namespace farshade::gpu
