/// Presenter: composes two pictures and a panel into the window, and returns while the device still draws:
/// what it costs a frame is recording, not drawing or showing.
#pragma once

#include <functional>

#include "stereo/gpu/swapchain.h"
#include "vr_client/preview/compose_pass.h"
#include "vr_client/preview/window.h"

namespace farshade {

/// Dear ImGui, its hands in `window` and its Vulkan back end, as long as this lives. One at a time.
class PanelContext {
 public:
  PanelContext(const gpu::Device& device, Window& window, const vk::raii::RenderPass& render_pass);
  PanelContext(const PanelContext&) = delete;
  PanelContext& operator=(const PanelContext&) = delete;
  ~PanelContext();

  /// Lays out what `draw` says with ImGui's calls; `record` draws it within the render pass.
  void lay_out(const std::function<void()>& draw);
  void record(const vk::raii::CommandBuffer& commands) const;

 private:
  Window& window_;
  vk::raii::DescriptorPool pool_{nullptr};
};

class Presenter {
 public:
  /// The device was opened for `window.presentation()`. `eyes`: as ComposePass takes them. All are kept.
  Presenter(const gpu::Device& device, Window& window, const gpu::Image& eyes);
  Presenter(const Presenter&) = delete;
  Presenter& operator=(const Presenter&) = delete;
  ~Presenter();

  /// NotNow: the window is minimised, or the display still holds all images; nothing was drawn, and
  /// `draw_panel` was not called.
  enum class Outcome : std::uint8_t { Shown, NotNow };

  /// Shows the composition and, over it, what `draw_panel` draws with ImGui. Never waits for the display.
  Outcome show(const Composition& composition, const std::function<void()>& draw_panel);

  /// Takes a picture of the eyes' size, for Picture::LeftUpload or RightUpload; it stays until the next.
  void upload(Side side, const Image<Rgb8>& picture) { compose_.upload(side, picture); }

  /// The composition at the window's size, without panel; empty while the window is minimised.
  [[nodiscard]] Image<Rgb8> read_back(const Composition& composition) const;

 private:
  /// What one frame in flight holds.
  struct Flight {
    vk::raii::CommandBuffer commands;
    vk::raii::Fence done;
    vk::raii::Semaphore image_ready;
  };
  void fit_to_window();
  void record(const Flight& flight, const Composition& composition, vk::Framebuffer target) const;

  const gpu::Device& device_;
  Window& window_;
  vk::raii::SurfaceKHR surface_;
  gpu::Swapchain swapchain_;
  vk::raii::RenderPass render_pass_;
  ComposePass compose_;
  PanelContext panel_;
  std::vector<vk::raii::Framebuffer> framebuffers_;  ///< one a swapchain image
  std::vector<vk::raii::Semaphore> drawn_;           ///< one a swapchain image
  std::vector<Flight> flights_;
  std::size_t next_flight_ = 0;
};

}  // namespace farshade
