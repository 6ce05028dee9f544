/// Presenter: composes two pictures and the panel into the window. It waits neither for the display nor,
/// while it shows, for the device: a frame for which there is no free image is not shown.
#pragma once

#include <optional>

#include "stereo/gpu/swapchain.h"
#include "vr_client/preview/compose_pass.h"
#include "vr_client/preview/panel_layer.h"

namespace farshade {

class Presenter {
 public:
  /// The device must have been opened with `window.presentation()`. `eyes` is the image for ComposePass. All
  /// references are kept.
  Presenter(const gpu::Device& device, Window& window, const gpu::Image& eyes);
  Presenter(const Presenter&) = delete;
  Presenter& operator=(const Presenter&) = delete;
  ~Presenter();

  /// Shows other eyes from now on: another image for ComposePass. The image so far may be gone, if the device
  /// has finished all work.
  void take_eyes(const gpu::Image& eyes) { compose_.emplace(device_, eyes, swapchain_.format()); }

  /// NotNow: nothing was drawn, because the window is minimised, or the display still uses all images, or the
  /// device has not finished the frame before the last.
  enum class Outcome : std::uint8_t { Shown, NotNow };

  /// Shows the composition, and above it the panel that `draw_panel` drew with ImGui. `draw_panel` is called
  /// when the panel must be redrawn, see PanelLayer.
  Outcome show(const Composition& composition, const std::function<void()>& draw_panel);

  /// Uploads a picture of the eyes' size for Picture::LeftUpload or RightUpload.
  void upload(Side side, const Image<Rgb8>& picture) { compose_->upload(side, picture); }

  /// The composition at the size of the window, without the panel. Empty while the window is minimised.
  [[nodiscard]] Image<Rgb8> read_back(const Composition& composition) const;

 private:
  /// Objects of one frame in flight.
  struct Flight {
    vk::raii::CommandBuffer commands;
    vk::raii::Fence done;
  };
  void fit_to_window();
  void acquire();
  [[nodiscard]] std::optional<std::uint32_t> free_image();
  void submit(const Flight& flight, vk::Semaphore drawn) const;

  const gpu::Device& device_;
  Window& window_;
  SteadyClock clock_;
  vk::raii::SurfaceKHR surface_;
  gpu::Swapchain swapchain_;
  std::optional<ComposePass> compose_;  ///< always set
  PanelLayer panel_;
  std::vector<vk::raii::Semaphore> drawn_;  ///< one per swapchain image
  vk::raii::Fence image_free_{nullptr};     ///< the acquired image may be drawn to
  std::optional<std::uint32_t> acquired_;   ///< the image that `image_free_` is for
  std::vector<Flight> flights_;
  std::size_t next_flight_ = 0;
};

}  // namespace farshade
