/// PanelLayer: draws Dear ImGui's windows into an image of its own. Most frames only copy this image (0.2
/// against 1.5 ms on a CPU device). The image is redrawn ten times per second, and in every frame while the
/// user interacts with the panel. The windows are opaque, so that a copy suffices.
#pragma once

#include <functional>
#include <optional>

#include "stereo/base/clock.h"
#include "stereo/gpu/memory.h"
#include "vr_client/preview/window.h"

namespace farshade {

/// Owns the contexts of Dear ImGui, its GLFW and its Vulkan back end. Only one may exist at a time.
class PanelLayer {
 public:
  /// `format` is the format of the swapchain. Both references are kept.
  PanelLayer(const gpu::Device& device, Window& window, vk::Format format);
  PanelLayer(const PanelLayer&) = delete;
  PanelLayer& operator=(const PanelLayer&) = delete;
  ~PanelLayer();

  /// True if the image is outdated, has the wrong size, or the user interacts with the panel. Then call
  /// `lay_out` and `record_drawing`.
  [[nodiscard]] bool is_due(Extent window, Time now) const;

  /// Begins an ImGui frame, calls `draw` and ends the frame.
  void lay_out(Extent window, Time now, const std::function<void()>& draw);
  void record_drawing(const vk::raii::CommandBuffer& commands);

  /// Copies the panel's windows into `target`, which must have the size of the last `lay_out` and be in
  /// layout TransferDstOptimal.
  void record_copy(const vk::raii::CommandBuffer& commands, vk::Image target) const;

 private:
  /// Does one of the panel's windows contain this point of the window, in pixels?
  [[nodiscard]] bool covers(glm::dvec2 place) const;
  void fit(Extent window);
  void follow_text_scale();

  const gpu::Device& device_;
  Window& window_;
  vk::Format format_;
  vk::raii::RenderPass render_pass_;
  vk::raii::DescriptorPool pool_{nullptr};
  gpu::Image image_;  ///< in layout TransferSrcOptimal after drawing
  vk::raii::Framebuffer framebuffer_{nullptr};
  std::vector<vk::Rect2D> windows_;  ///< rectangles of ImGui's windows within the image
  std::optional<Time> laid_out_;
  double text_scale_ = 0;  ///< of the current style; 0 before the first
};

}  // namespace farshade
