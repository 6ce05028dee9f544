/// Window: the window of the preview and its keyboard and mouse input. Only window.cpp uses GLFW. All calls
/// must come from the thread that opened the window.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "stereo/base/clock.h"
#include "stereo/base/expected.h"
#include "stereo/gpu/device.h"
#include "vr_client/preview/input.h"
#include "vr_client/preview/layout.h"

struct GLFWwindow;

namespace farshade {

class Window;

/// What a user can do who has no desktop.
inline constexpr const char* kPreviewCure =
    "run it in a desktop session, through `ssh -X` or under `xvfb-run -a`, or omit --preview to write "
    "pictures to out/";

/// Chooses the size of a new window, pixels.
using SizeOnDesktop = std::function<Extent(const Desktop&)>;

/// Opens and shows a window in the middle of the primary monitor's work area. Missing, with a cure, if there
/// is no desktop; without DISPLAY and WAYLAND_DISPLAY the function does not try. Only one window may exist.
[[nodiscard]] Expected<std::unique_ptr<Window>> open_window(const std::string& title,
                                                            const SizeOnDesktop& size,
                                                            const std::string& cure = kPreviewCure);

class Window {
 public:
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  ~Window();

  /// What a device must support to present to windows. The result does not refer to this window.
  [[nodiscard]] gpu::Presentation presentation() const;
  /// Throws if the instance lacks an extension of `presentation`. The surface must be destroyed before the
  /// window.
  [[nodiscard]] vk::raii::SurfaceKHR make_surface(const vk::raii::Instance& instance) const;

  [[nodiscard]] Extent framebuffer_size() const;  ///< pixels; zero while the window is minimised
  [[nodiscard]] double text_scale() const;        ///< of this window on this desktop
  [[nodiscard]] glm::dvec2 cursor_px() const;     ///< position of the mouse in the framebuffer, pixels
  [[nodiscard]] bool should_close() const;
  void set_title(const std::string& title);

  /// The input since the last call.
  Input poll();
  /// Returns at the next event, or after `longest`. `poll` returns that event.
  void wait(Duration longest);

  /// From attach_panel to detach_panel, the current context of Dear ImGui gets mouse and keys too. `covers`
  /// must return whether the displayed panel contains a point, in pixels of the window. Clicks there go to
  /// the panel.
  void attach_panel(std::function<bool(glm::dvec2)> covers);
  void detach_panel();
  /// Call it before ImGui::NewFrame. The panel uses pixel coordinates.
  void begin_panel();

 private:
  friend Expected<std::unique_ptr<Window>> open_window(const std::string& title, const SizeOnDesktop& size,
                                                       const std::string& cure);
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
