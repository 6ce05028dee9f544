/// A desktop for one test program: an X server of its own (Xvfb, 1600x900), where windows are found, looked
/// at, resized and closed, and where keys are pressed and the mouse is moved, as a user would.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "stereo/image/image.h"
#include "tests/integration/child_program.h"

namespace farshade {

class XScreen {
 public:
  using WindowId = unsigned long;

  /// Starts the server on a display that is free and sets DISPLAY to it. Aborts where there is no Xvfb.
  XScreen();
  XScreen(const XScreen&) = delete;
  XScreen& operator=(const XScreen&) = delete;
  ~XScreen();

  [[nodiscard]] const std::string& display() const { return name_; }

  /// Starts a window manager (twm), without which windows are neither minimised nor framed.
  void manage_windows();

  /// The viewable window whose title begins so.
  [[nodiscard]] std::optional<WindowId> find(const std::string& title);
  /// The same, waiting up to ten seconds for it.
  [[nodiscard]] std::optional<WindowId> wait_for(const std::string& title);
  /// Calls `holds` whenever something happens on the screen, and now and then; false after ten seconds.
  [[nodiscard]] bool wait_until(const std::function<bool()>& holds);

  [[nodiscard]] Extent size_of(WindowId window);
  [[nodiscard]] std::string title_of(WindowId window);
  /// What is on the screen within the window.
  [[nodiscard]] Image<Rgb8> screenshot(WindowId window);

  // Hands. Keys by their X names: "w", "F1", "space", "Shift_L". Mouse within the window, pixels.
  void focus(WindowId window);
  void press(const std::string& key);
  void release(const std::string& key);
  void tap(const std::string& key);
  void move_mouse(WindowId window, int x, int y);
  void press_button(unsigned button = 1);
  void release_button(unsigned button = 1);

  // What a window manager does, or asks for.
  void resize(WindowId window, Extent size);
  void close(WindowId window);  ///< WM_DELETE_WINDOW: the cross in the frame
  void iconify(WindowId window);
  void restore(WindowId window);

 private:
  struct Connection;
  std::unique_ptr<ChildProgram> server_, manager_;
  std::string name_;
  std::unique_ptr<Connection> x_;
};

}  // namespace farshade
