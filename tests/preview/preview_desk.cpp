#include "tests/preview/preview_desk.h"

#include <fmt/format.h>
#include <unistd.h>

#include "tests/integration/test_keys.h"
#include "tests/support/image_reader.h"

namespace farshade {

PreviewDesk::PreviewDesk()
    : out_(std::filesystem::path(testing::TempDir()) / fmt::format("farshade_preview.{}", getpid())) {
  std::filesystem::remove_all(out_);
}

PreviewDesk::~PreviewDesk() {
  program_.reset();
  std::error_code ignored;
  std::filesystem::remove_all(out_, ignored);
}

void PreviewDesk::start(const std::vector<std::string>& options) {
  if (!server_) server_ = std::make_unique<RunningServer>();
  // The Vulkan loader unloads drivers at the end. A leak suppression cannot name a module that is unloaded.
  std::vector<std::string> arguments{"/usr/bin/env", "LSAN_OPTIONS=detect_leaks=0",
                                     "XDG_STATE_HOME=" + (out_ / "state").string()};
  const std::string size = fmt::format("{}x{}", kDeskEye.width, kDeskEye.height);
  arguments.insert(arguments.end(),
                   {VR_CLIENT, "--preview", "--scene", kRoom, "--size", size, "--key", test_keys().client,
                    "--server", server_->address(), "--out", out_.string()});
  arguments.insert(arguments.end(), options.begin(), options.end());
  program_ = std::make_unique<ChildProgram>(arguments);
}

void PreviewDesk::open(const std::vector<std::string>& options) {
  start(options);
  // The title names the scene after the first frame.
  ASSERT_TRUE(patiently([&] {
    const auto found = screen_.find("Farshade: ");
    window_ = found.value_or(0);
    return found.has_value();
  })) << "no window shows frames";
  screen_.focus(window_);
  for (const char* key : {"Tab", "x"}) screen_.tap(key);
}

bool PreviewDesk::patiently(const std::function<bool()>& holds) {
  return screen_.wait_until(holds);
}

bool PreviewDesk::changes(int times) {
  Image<Rgb8> last = screen_.screenshot(window_);
  return patiently([&] {
    Image<Rgb8> now = screen_.screenshot(window_);
    if (now != last) {
      --times;
      last = std::move(now);
    }
    return times <= 0;
  });
}

bool PreviewDesk::appears(const std::filesystem::path& file) {
  return patiently([&] { return std::filesystem::exists(file); });
}

void PreviewDesk::resize(Extent size) {
  screen_.resize(window_, size);
  EXPECT_TRUE(patiently([&] { return screen_.size_of(window_) == size; }));
}

EyePictures PreviewDesk::take_screenshot() {
  screen_.tap("F12");
  const std::string name = (out_ / fmt::format("screenshot_{:04}_", ++screenshots_)).string();
  EyePictures pictures;
  // A file exists before it is complete. The picture of the window is written last.
  EXPECT_TRUE(patiently([&] {
    if (!std::filesystem::exists(name + "window.png")) return false;
    auto window = read_png(name + "window.png");
    if (window) pictures.window = std::move(*window);
    return window.has_value();
  })) << name;
  pictures.left = read_png(name + "left.png").value();
  pictures.right = read_png(name + "right.png").value();
  return pictures;
}

int PreviewDesk::end() {
  errors_ = program_->errors();
  return program_->wait();
}

Image<Rgb8> crop(const Image<Rgb8>& image, std::uint32_t left, std::uint32_t top, Extent size) {
  Image<Rgb8> result(size);
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) result.at(x, y) = image.at(left + x, top + y);
  return result;
}

}  // namespace farshade
