/// Panel layer: what Dear ImGui draws, on an image of its own, so that a frame pays for a copy and not for
/// its triangles (0.2 against 1.5 ms on a CPU device): people read figures ten times a second at most. While
/// hands are on the panel it is drawn anew for every frame. Its windows are opaque, so that copies are
/// enough.
#pragma once

#include <functional>
#include <optional>

#include "stereo/base/clock.h"
#include "stereo/gpu/memory.h"
#include "vr_client/preview/window.h"

namespace farshade {

/// Dear ImGui, its hands in the window and its Vulkan back end, as long as this lives. One at a time.
class PanelLayer {
 public:
  /// Pictures of `format`. Both references are kept.
  PanelLayer(const gpu::Device& device, Window& window, vk::Format format);
  PanelLayer(const PanelLayer&) = delete;
  PanelLayer& operator=(const PanelLayer&) = delete;
  ~PanelLayer();

  /// Whether the picture of it is old, too small or touched; then `lay_out` and `record_drawing` are to
  /// follow.
  [[nodiscard]] bool is_due(Extent window, Time now) const;

  /// Lays out what `draw` says with ImGui's calls.
  void lay_out(Extent window, Time now, const std::function<void()>& draw);
  void record_drawing(const vk::raii::CommandBuffer& commands);

  /// Copies the panel's windows over `target`, which is of the size last laid out and in layout
  /// TransferDstOptimal.
  void record_copy(const vk::raii::CommandBuffer& commands, vk::Image target) const;

 private:
  /// A place in the window, pixels.
  [[nodiscard]] bool covers(glm::dvec2 place) const;
  void fit(Extent window);

  const gpu::Device& device_;
  Window& window_;
  vk::Format format_;
  vk::raii::RenderPass render_pass_;
  vk::raii::DescriptorPool pool_{nullptr};
  gpu::Image image_;  ///< in layout TransferSrcOptimal after drawing
  vk::raii::Framebuffer framebuffer_{nullptr};
  std::vector<vk::Rect2D> windows_;  ///< of the panel, within the image
  std::optional<Time> laid_out_;
};

}  // namespace farshade
