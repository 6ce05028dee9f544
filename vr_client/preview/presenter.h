/// Presenter: composes two pictures and a panel into the window, and does not wait for the display.
#pragma once

#include "stereo/gpu/swapchain.h"
#include "vr_client/preview/compose_pass.h"
#include "vr_client/preview/panel_layer.h"

namespace farshade {

class Presenter {
 public:
  /// The device was opened for `window.presentation()`. `eyes`: as ComposePass takes them. All are kept.
  Presenter(const gpu::Device& device, Window& window, const gpu::Image& eyes);
  Presenter(const Presenter&) = delete;
  Presenter& operator=(const Presenter&) = delete;
  ~Presenter();

  /// NotNow: the window is minimised, or the display still holds all images; nothing was drawn.
  enum class Outcome : std::uint8_t { Shown, NotNow };

  /// Shows the composition and, over it, what `draw_panel` last drew with ImGui. It is called when the panel
  /// is to be drawn anew: ten times a second, and for every frame while hands are on it.
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
  void submit(const Flight& flight, vk::Semaphore drawn) const;

  const gpu::Device& device_;
  Window& window_;
  SteadyClock clock_;
  vk::raii::SurfaceKHR surface_;
  gpu::Swapchain swapchain_;
  ComposePass compose_;
  PanelLayer panel_;
  std::vector<vk::raii::Semaphore> drawn_;  ///< one a swapchain image
  std::vector<Flight> flights_;
  std::size_t next_flight_ = 0;
};

}  // namespace farshade
