/// An X server (Xvfb, 1600x900) for one test program. Tests find, read, resize and close windows, press keys
/// and move the mouse, as a user would.
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

  /// Starts the server on a free display and sets DISPLAY. Aborts if Xvfb is missing.
  XScreen();
  XScreen(const XScreen&) = delete;
  XScreen& operator=(const XScreen&) = delete;
  ~XScreen();

  [[nodiscard]] const std::string& display() const { return name_; }

  /// Starts a window manager (twm), which is needed to minimise windows and to draw frames.
  void manage_windows();

  /// The visible window whose title begins with this text.
  [[nodiscard]] std::optional<WindowId> find(const std::string& title);
  /// The same, but waits up to a minute for it.
  [[nodiscard]] std::optional<WindowId> wait_for(const std::string& title);
  /// Repeats `holds` after each event and regularly until it returns true. False after a minute.
  [[nodiscard]] bool wait_until(const std::function<bool()>& holds);

  [[nodiscard]] Extent size_of(WindowId window);
  [[nodiscard]] std::string title_of(WindowId window);
  /// The displayed content of the window.
  [[nodiscard]] Image<Rgb8> screenshot(WindowId window);

  // Input. Keys have their X names: "w", "F1", "space", "Shift_L". Mouse positions are pixels of the window.
  void focus(WindowId window);
  void press(const std::string& key);
  void release(const std::string& key);
  void tap(const std::string& key);
  void move_mouse(WindowId window, int x, int y);
  void press_button(unsigned button = 1);
  void release_button(unsigned button = 1);

  // Actions of a window manager.
  void resize(WindowId window, Extent size);  ///< and move it to the corner, so that all of it can be read
  void close(WindowId window);                ///< WM_DELETE_WINDOW: the cross in the frame
  void iconify(WindowId window);
  void restore(WindowId window);
  /// Covers all windows by one that is as large as the screen.
  void cover();

 private:
  struct Connection;
  std::unique_ptr<ChildProgram> server_, manager_;
  std::string name_;
  std::unique_ptr<Connection> x_;
};

}  // namespace farshade
