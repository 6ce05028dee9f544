/// A desk to try the preview at: `vr_client --preview` of the bundled room as a child process with an
/// rt_server of its own, on a screen of its own, writing to a folder of its own. Deadlines are a minute, so
/// that a machine that is busy with other things fails no test.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "tests/integration/client_program.h"
#include "tests/preview/x_screen.h"

namespace farshade {

inline constexpr Extent kDeskEye{96, 96};

struct EyePictures {
  Image<Rgb8> left, right, window;
};

class PreviewDesk : public testing::Test {
 protected:
  PreviewDesk();
  ~PreviewDesk() override;

  /// Starts the preview with `options` besides those of the desk, waits for its first shown frames, hides the
  /// panel and stops the room's animation.
  void open(const std::vector<std::string>& options = {});
  /// Starts it alone; its window may never come.
  void start(const std::vector<std::string>& options = {});

  /// Calls `holds` until it does, for a minute at most.
  [[nodiscard]] bool patiently(const std::function<bool()>& holds);
  /// Waits until what is on the screen in the window has changed `times` times.
  [[nodiscard]] bool changes(int times = 1);
  [[nodiscard]] bool appears(const std::filesystem::path& file);
  void resize(Extent size);
  /// Presses F12 and gives what it wrote: the eyes and the window, without panel.
  [[nodiscard]] EyePictures take_screenshot();

  /// The program's exit status, once it ends; its errors are in `errors_`.
  [[nodiscard]] int end();

  const std::filesystem::path out_;
  XScreen screen_;
  std::unique_ptr<RunningServer> server_;
  std::unique_ptr<ChildProgram> program_;
  XScreen::WindowId window_ = 0;
  std::string errors_;

 private:
  int screenshots_ = 0;
};

/// The pixels of `image` from (left, top) on.
[[nodiscard]] Image<Rgb8> crop(const Image<Rgb8>& image, std::uint32_t left, std::uint32_t top, Extent size);

}  // namespace farshade
