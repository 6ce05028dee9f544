#include "vr_client/preview/presenter.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

/// The device draws one frame while the next is recorded.
constexpr std::uint32_t kFlights = 2;

/// The display gives an acquired image back within this time, or never.
constexpr std::uint64_t kLongestAcquire_ns = 1'000'000'000;

}  // namespace

Presenter::Presenter(const gpu::Device& device, Window& window, const gpu::Image& eyes)
    : device_(device),
      window_(window),
      surface_(window.make_surface(device.instance)),
      swapchain_(device, surface_),
      compose_(std::in_place, device, eyes, swapchain_.format()),
      panel_(device, window, swapchain_.format()),
      image_free_(device.logical.createFence({})) {
  auto commands = device.logical.allocateCommandBuffers({.commandPool = *device.commands,
                                                         .level = vk::CommandBufferLevel::ePrimary,
                                                         .commandBufferCount = kFlights});
  for (auto& buffer : commands)
    flights_.push_back(
        {std::move(buffer), device.logical.createFence({.flags = vk::FenceCreateFlagBits::eSignaled})});
}

Presenter::~Presenter() {
  try {
    device_.logical.waitIdle();
    if (acquired_) static_cast<void>(device_.logical.waitForFences(*image_free_, true, kLongestAcquire_ns));
  } catch (const vk::SystemError&) {
    // The device is lost. The call that lost it has thrown already.
  }
}

void Presenter::fit_to_window() {
  if (!swapchain_.fit(window_.framebuffer_size())) return;
  acquired_.reset();
  drawn_.clear();
  for (std::size_t i = 0; i < swapchain_.targets().size(); ++i)
    drawn_.push_back(device_.logical.createSemaphore({}));
}

void Presenter::acquire() {
  device_.logical.resetFences(*image_free_);
  acquired_ = swapchain_.acquire(*image_free_);
}

/// The index of an image that may be drawn to, if there is one now.
std::optional<std::uint32_t> Presenter::free_image() {
  if (acquired_ && image_free_.getStatus() == vk::Result::eNotReady) return std::nullopt;
  fit_to_window();
  if (swapchain_.size().pixels() == 0) return std::nullopt;
  if (!acquired_) acquire();
  return acquired_ && image_free_.getStatus() == vk::Result::eSuccess ? acquired_ : std::nullopt;
}

Presenter::Outcome Presenter::show(const Composition& composition, const std::function<void()>& draw_panel) {
  const Flight& flight = flights_[next_flight_];
  if (flight.done.getStatus() != vk::Result::eSuccess) return Outcome::NotNow;
  const auto index = free_image();
  if (!index) return Outcome::NotNow;
  const Extent size = swapchain_.size();
  const gpu::Swapchain::Target& target = swapchain_.targets()[*index];
  flight.commands.reset();
  flight.commands.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  if (const Time now = clock_.now(); panel_.is_due(size, now)) {
    panel_.lay_out(size, now, draw_panel);
    panel_.record_drawing(flight.commands);
  }
  compose_->record(flight.commands, composition, {target.image, *target.view, size});
  panel_.record_copy(flight.commands, target.image);
  gpu::transition(flight.commands, target.image, Layout::eTransferDstOptimal, Layout::ePresentSrcKHR);
  flight.commands.end();
  submit(flight, *drawn_[*index]);
  swapchain_.present(*index, *drawn_[*index]);
  acquire();  // ahead, because drivers signal the fence some time later
  next_flight_ = (next_flight_ + 1) % flights_.size();
  return Outcome::Shown;
}

void Presenter::submit(const Flight& flight, vk::Semaphore drawn) const {
  device_.logical.resetFences(*flight.done);
  device_.queue.submit(vk::SubmitInfo{.commandBufferCount = 1,
                                      .pCommandBuffers = &*flight.commands,
                                      .signalSemaphoreCount = 1,
                                      .pSignalSemaphores = &drawn},
                       *flight.done);
}

Image<Rgb8> Presenter::read_back(const Composition& composition) const {
  const Extent size = window_.framebuffer_size();
  if (size.pixels() == 0) return {};
  using Usage = vk::ImageUsageFlagBits;
  const gpu::Image target =
      gpu::make_image(device_,
                      {.size = size,
                       .format = swapchain_.format(),
                       .usage = Usage::eColorAttachment | Usage::eTransferDst | Usage::eTransferSrc},
                      "composed");
  const gpu::ReadbackBuffer pixels = gpu::make_readback_buffer(
      device_, size.pixels() * 4, vk::BufferUsageFlagBits::eTransferDst, "composed read-back");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    compose_->record(commands, composition, {*target.image, *target.view, size});
    gpu::transition(commands, target, Layout::eTransferDstOptimal, Layout::eTransferSrcOptimal);
    commands.copyImageToBuffer(
        *target.image, Layout::eTransferSrcOptimal, *pixels.buffer,
        vk::BufferImageCopy{.imageSubresource = {vk::ImageAspectFlagBits::eColor, 0, 0, 1},
                            .imageExtent = {size.width, size.height, 1}});
    gpu::show_copies_to_host(commands);
  });
  Image<Rgb8> result(size);
  const bool blue_first = swapchain_.format() == vk::Format::eB8G8R8A8Unorm;
  for (std::size_t i = 0; i < size.pixels(); ++i) {
    const Rgba8 pixel = pixels.as<Rgba8>()[i];
    result.pixels[i] = blue_first ? Rgb8(pixel.z, pixel.y, pixel.x) : Rgb8(pixel);
  }
  return result;
}

}  // namespace farshade
