/// Fixture for tests of `vr_client --preview`: runs it with the bundled room as a child process, with its own
/// rt_server, X screen and output folder. Timeouts are one minute, so that a busy machine fails no test.
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
 public:
  PreviewDesk();
  PreviewDesk(const PreviewDesk&) = delete;
  PreviewDesk& operator=(const PreviewDesk&) = delete;
  ~PreviewDesk() override;

 protected:
  /// Starts the preview with additional `options`, waits for its first frames, hides the panel and stops the
  /// animation of the room.
  void open(const std::vector<std::string>& options = {});
  /// Only starts the preview. It may never open a window.
  void start(const std::vector<std::string>& options = {});

  /// Repeats `holds` until it returns true, for at most one minute.
  [[nodiscard]] bool patiently(const std::function<bool()>& holds);
  /// Waits until the content of the window has changed `times` times.
  [[nodiscard]] bool changes(int times = 1);
  [[nodiscard]] bool appears(const std::filesystem::path& file);
  void resize(Extent size);
  /// The file in which the preview keeps its layout.
  [[nodiscard]] std::filesystem::path remembered() const { return out_ / "state/farshade/preview.json"; }
  /// Presses F12 and returns the written pictures: the eyes, and the window without its panel.
  [[nodiscard]] EyePictures take_screenshot();

  /// Waits for the end of the program and returns its exit status. Stores its error output in `errors_`.
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

/// The part of `image` that begins at (left, top).
[[nodiscard]] Image<Rgb8> crop(const Image<Rgb8>& image, std::uint32_t left, std::uint32_t top, Extent size);

}  // namespace farshade
