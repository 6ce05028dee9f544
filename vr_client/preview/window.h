/// Window: the one on the desktop that the preview shows in, and the hands of who looks at it.
/// The only room that knows GLFW; all calls from the thread that opened it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "stereo/base/clock.h"
#include "stereo/base/expected.h"
#include "stereo/base/extent.h"
#include "stereo/gpu/device.h"
#include "vr_client/preview/input.h"

struct GLFWwindow;

namespace farshade {

class Window;

/// A window of `size` (pixels, times the desktop's content scale) that is shown at once. Missing, with the
/// cure, where there is no desktop to open it on: without DISPLAY and WAYLAND_DISPLAY none is even looked
/// for. One at a time.
[[nodiscard]] Expected<std::unique_ptr<Window>> open_window(const std::string& title, Extent size);

class Window {
 public:
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  ~Window();

  /// What a device must have to show here. Refers to no window: any device may be asked.
  [[nodiscard]] gpu::Presentation presentation() const;
  /// Throws where the instance lacks what `presentation` asks for. Must be gone before the window.
  [[nodiscard]] vk::raii::SurfaceKHR make_surface(const vk::raii::Instance& instance) const;

  [[nodiscard]] Extent framebuffer_size() const;  ///< pixels; zero while it is minimised
  [[nodiscard]] double content_scale() const;     ///< how much larger than usual the desktop wants text
  [[nodiscard]] glm::dvec2 cursor_px() const;     ///< the mouse within the framebuffer, pixels
  [[nodiscard]] bool should_close() const;
  void set_title(const std::string& title);

  /// What has happened since the last call.
  Input poll();
  /// Returns when something happens, or after `longest`; what happens is kept for `poll`.
  void wait(Duration longest);

  // The panel's hands: Dear ImGui's current context is told of mouse and keys between these two.
  /// `covers` says whether a place, in pixels of the window, is the panel's as it now is on show: who presses
  /// there means the panel.
  void attach_panel(std::function<bool(glm::dvec2)> covers);
  void detach_panel();
  /// Before ImGui::NewFrame. The panel counts in pixels.
  void begin_panel();

 private:
  friend Expected<std::unique_ptr<Window>> open_window(const std::string& title, Extent size);
  explicit Window(GLFWwindow* window);
  void on_key(int key, int action);
  void on_mouse_button(int button, int action);
  void on_cursor(glm::dvec2 position);
  void on_scroll(double notches);

  GLFWwindow* window_;
  enum class Panel : std::uint8_t { None, Attached } panel_ = Panel::None;
  enum class Mouse : std::uint8_t { Free, Dragging } mouse_ = Mouse::Free;
  glm::dvec2 cursor_{0, 0};
  std::function<bool(glm::dvec2)> panel_covers_;
  Input input_;
};

}  // namespace farshade
