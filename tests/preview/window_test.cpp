#include "vr_client/preview/window.h"
#include "stereo/gpu/device.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <stdexcept>

#include "tests/preview/x_screen.h"
#include "vr_client/preview/presenter.h"

namespace farshade {
namespace {

constexpr Extent kEye{512, 512}, kWindow{1040, 540};
constexpr const char* kTitle = "Farshade window test";

Extent of_window(const Desktop&) {
  return kWindow;
}

/// All tests of this program share this screen. Each opens and closes its own window.
class Screen final : public testing::Environment {
 public:
  static XScreen& get() { return *instance()->screen_; }
  static Screen* instance() {
    static auto* screen = dynamic_cast<Screen*>(testing::AddGlobalTestEnvironment(new Screen));
    return screen;
  }
  void SetUp() override { screen_ = std::make_unique<XScreen>(); }
  void TearDown() override { screen_.reset(); }

 private:
  std::unique_ptr<XScreen> screen_;
};
[[maybe_unused]] const Screen* const kScreen = Screen::instance();

/// Neighbouring pixels differ, and so do the eyes, so that a shift by one pixel or a swap is detected.
Image<Rgb8> pattern(Side side) {
  Image<Rgb8> image(kEye);
  for (std::uint32_t y = 0; y < kEye.height; ++y)
    for (std::uint32_t x = 0; x < kEye.width; ++x)
      image.at(x, y) = Rgb8(x * 7 + y, y * 5 + x / 2, side == Side::Left ? x * y / 64 : 255 - y / 2);
  return image;
}

/// Two layers in layout General, as the renderer leaves them.
gpu::Image make_eyes(const gpu::Device& device) {
  using Layout = vk::ImageLayout;
  using Usage = vk::ImageUsageFlagBits;
  gpu::Image eyes = gpu::make_image(device,
                                    {.size = kEye,
                                     .layers = kEyes,
                                     .format = vk::Format::eR8G8B8A8Unorm,
                                     .usage = Usage::eStorage | Usage::eTransferDst | Usage::eTransferSrc},
                                    "eyes");
  const gpu::StagingBuffer staging =
      gpu::make_staging_buffer(device, kEye.pixels() * kEyes * 4, "eyes staging");
  for (const Side side : kSides) {
    const Image<Rgb8> picture = pattern(side);
    staging.view<Rgba8>().part(index_of(side) * kEye.pixels(), kEye.pixels()).generate([&](std::size_t i) {
      return Rgba8(picture.pixels[i], 255);
    });
  }
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, eyes, Layout::eUndefined, Layout::eTransferDstOptimal);
    commands.copyBufferToImage(
        *staging.buffer, *eyes.image, Layout::eTransferDstOptimal,
        vk::BufferImageCopy{.imageSubresource = {vk::ImageAspectFlagBits::eColor, 0, 0, kEyes},
                            .imageExtent = {kEye.width, kEye.height, 1}});
    gpu::transition(commands, eyes, Layout::eTransferDstOptimal, Layout::eGeneral);
  });
  return eyes;
}

Image<Rgb8> crop(const Image<Rgb8>& image, const Panel& panel) {
  Image<Rgb8> result(panel.size);
  for (std::uint32_t y = 0; y < panel.size.height; ++y)
    for (std::uint32_t x = 0; x < panel.size.width; ++x)
      result.at(x, y) = image.at(panel.left + x, panel.top + y);
  return result;
}

/// The largest difference of any channel of any pixel.
int largest_difference(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  EXPECT_EQ(a.size, b.size);
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels.size() && a.size == b.size; ++i)
    for (int channel = 0; channel < 3; ++channel)
      largest = std::max(largest, std::abs(a.pixels[i][channel] - b.pixels[i][channel]));
  return largest;
}

template <class T>
T value_of(Expected<T> expected) {
  if (!expected) throw std::runtime_error(expected.error().what);
  return std::move(*expected);
}

void no_panel() {}

/// A window with a presenter. No test may cause a message of the validation layers.
class PreviewWindow : public testing::Test {
 protected:
  void open(gpu::Validation validation = gpu::Validation::On) {
    window_ = value_of(open_window(kTitle, of_window));
    device_ = value_of(gpu::open_device(
        {.name_contains = "llvmpipe", .validation = validation, .presentation = window_->presentation()}));
    eyes_ = make_eyes(*device_);
    presenter_ = std::make_unique<Presenter>(*device_, *window_, eyes_);
    id_ = screen_.wait_for(kTitle).value();
    screen_.focus(id_);
    window_->poll();
  }

  void TearDown() override {
    presenter_.reset();
    if (!device_ || !device_->validation_log) return;
    for (const std::string& message : device_->validation_log->messages()) ADD_FAILURE() << message;
  }

  /// The pixels of the window, after they have become equal to those of `read_back`.
  Image<Rgb8> on_screen(const Composition& composition) {
    Image<Rgb8> expected, seen;
    const bool same = screen_.wait_until([&] {
      window_->poll();
      presenter_->show(composition, no_panel);
      expected = presenter_->read_back(composition);
      seen = screen_.screenshot(id_);
      return seen == expected;
    });
    EXPECT_TRUE(same) << "on screen " << seen.size.width << " x " << seen.size.height << ", expected "
                      << expected.size.width << " x " << expected.size.height << ", differing by "
                      << largest_difference(seen, expected);
    return seen;
  }

  /// Polls events until `holds` returns true for them.
  bool poll_until(const std::function<bool(const Input&)>& holds) {
    return screen_.wait_until([&] { return holds(window_->poll()); });
  }

  XScreen& screen_ = Screen::get();
  std::unique_ptr<Window> window_;
  std::optional<gpu::Device> device_;
  gpu::Image eyes_;
  std::unique_ptr<Presenter> presenter_;
  XScreen::WindowId id_ = 0;
};

TEST_F(PreviewWindow, ShowsBothEyesUnscaled) {
  open();
  const Image<Rgb8> seen = on_screen({});
  const auto panels = panel_rects(kWindow, kEye, 1, StereoLayout::SideBySide);
  ASSERT_EQ(seen.size, kWindow);
  for (const Side side : kSides)
    EXPECT_EQ(crop(seen, panels[index_of(side)]), pattern(side)) << name_of(side);
  EXPECT_EQ(seen.at(0, 0), Rgb8(0));
  EXPECT_EQ(seen.at(520, 270), Rgb8(0)) << "between the eyes";
}

TEST_F(PreviewWindow, CrossedEyesAreSwapped) {
  open();
  const Image<Rgb8> seen = on_screen({.layout = StereoLayout::CrossEyed});
  const auto panels = panel_rects(kWindow, kEye, 1, StereoLayout::SideBySide);
  EXPECT_EQ(crop(seen, panels[0]), pattern(Side::Right));
  EXPECT_EQ(crop(seen, panels[1]), pattern(Side::Left));
}

TEST_F(PreviewWindow, ShowsAnUploadBesideAnEye) {
  open();
  Image<Rgb8> picture(kEye, Rgb8(1, 2, 3));
  picture.at(511, 0) = Rgb8(250, 251, 252);
  presenter_->upload(Side::Right, picture);
  const Image<Rgb8> seen = on_screen({.pictures = {Picture::LeftEye, Picture::RightUpload}});
  const auto panels = panel_rects(kWindow, kEye, 1, StereoLayout::SideBySide);
  EXPECT_EQ(crop(seen, panels[0]), pattern(Side::Left));
  EXPECT_EQ(crop(seen, panels[1]), picture);
  const Image<Rgb8> alone =
      on_screen({.layout = StereoLayout::Mono, .pictures = {Picture::RightUpload, Picture::LeftEye}});
  EXPECT_EQ(crop(alone, panel_rects(kWindow, kEye, 1, StereoLayout::Mono)[0]), picture);
}

double linear_of(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
double srgb_of(double light) {
  return light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/// One row for each of the window's red, green and blue: the weights of the left eye's colour, then of the
/// right eye's. E. Dubois, ICASSP 2001.
Rgb8 dubois(Rgb8 left, Rgb8 right) {
  constexpr double rows[3][6] = {{0.4561, 0.500484, 0.176381, -0.0434706, -0.0879388, -0.00155529},
                                 {-0.0400822, -0.0378246, -0.0157589, 0.378476, 0.73364, -0.0184503},
                                 {-0.0152161, -0.0205971, -0.00546856, -0.0721527, -0.112961, 1.2264}};
  Rgb8 result;
  for (int row = 0; row < 3; ++row) {
    double light = 0;
    for (int i = 0; i < 3; ++i)
      light += rows[row][i] * linear_of(left[i] / 255.0) + rows[row][i + 3] * linear_of(right[i] / 255.0);
    result[row] = static_cast<std::uint8_t>(std::lround(255 * srgb_of(std::clamp(light, 0.0, 1.0))));
  }
  return result;
}

TEST_F(PreviewWindow, AnaglyphHasTheLeastSquaresColours) {
  open();
  const Image<Rgb8> seen = on_screen({.layout = StereoLayout::Anaglyph}), left = pattern(Side::Left),
                    right = pattern(Side::Right);
  Image<Rgb8> expected(kEye);
  for (std::size_t i = 0; i < kEye.pixels(); ++i)
    expected.pixels[i] = dubois(left.pixels[i], right.pixels[i]);
  EXPECT_LE(
      largest_difference(crop(seen, panel_rects(kWindow, kEye, 1, StereoLayout::Anaglyph)[0]), expected), 1);
}

/// Bilinear filtering, as the shader should do it.
Rgb8 between(const Image<Rgb8>& image, double x, double y) {
  const double at_x = std::clamp(x - 0.5, 0.0, image.size.width - 1.0),
               at_y = std::clamp(y - 0.5, 0.0, image.size.height - 1.0);
  const auto low_x = static_cast<std::uint32_t>(at_x), low_y = static_cast<std::uint32_t>(at_y);
  const std::uint32_t high_x = std::min(low_x + 1, image.size.width - 1),
                      high_y = std::min(low_y + 1, image.size.height - 1);
  const glm::dvec3 top =
      glm::mix(glm::dvec3(image.at(low_x, low_y)), glm::dvec3(image.at(high_x, low_y)), at_x - low_x);
  const glm::dvec3 bottom =
      glm::mix(glm::dvec3(image.at(low_x, high_y)), glm::dvec3(image.at(high_x, high_y)), at_x - low_x);
  return Rgb8(glm::round(glm::mix(top, bottom, at_y - low_y)));
}

TEST_F(PreviewWindow, FollowsItsSizeAndKeepsTheAspectRatio) {
  open();
  on_screen({});
  for (const Extent size : {Extent{700, 640}, {1500, 320}, {1040, 540}}) {
    screen_.resize(id_, size);
    ASSERT_TRUE(screen_.wait_until([&] {
      window_->poll();
      return window_->framebuffer_size() == size;
    }));
    const Image<Rgb8> seen = on_screen({});
    ASSERT_EQ(seen.size, size);
    const auto panels = panel_rects(size, kEye, 1, StereoLayout::SideBySide);
    for (const Panel& panel : panels) {
      EXPECT_EQ(panel.size.width, panel.size.height);
      const Image<Rgb8> picture = pattern(kSides[panel.eye]);
      Image<Rgb8> expected(panel.size);
      const double step = 512.0 / panel.size.width;
      for (std::uint32_t y = 0; y < panel.size.height; ++y)
        for (std::uint32_t x = 0; x < panel.size.width; ++x)
          expected.at(x, y) = between(picture, (x + 0.5) * step, (y + 0.5) * step);
      // Devices may filter with weights of 8 bits.
      EXPECT_LE(largest_difference(crop(seen, panel), expected), 2);
    }
  }
}

TEST_F(PreviewWindow, DrawsThePanelOverThePictures) {
  open();
  const auto panel = [] {
    ImGui::SetNextWindowPos({20, 30});
    ImGui::SetNextWindowSize({200, 100});
    ImGui::Begin("panel");
    ImGui::TextUnformatted("figures");
    ImGui::End();
  };
  const Image<Rgb8> bare = on_screen({});
  Image<Rgb8> seen;
  EXPECT_TRUE(screen_.wait_until([&] {
    window_->poll();
    presenter_->show({}, panel);
    seen = screen_.screenshot(id_);
    return largest_difference(seen, bare) > 100;
  }));
  EXPECT_EQ(presenter_->read_back({}), bare) << "pictures of the composition have no panel";
  const auto differs = [&](std::uint32_t x, std::uint32_t y) { return seen.at(x, y) != bare.at(x, y); };
  EXPECT_TRUE(differs(100, 80));
  for (std::uint32_t y = 0; y < kWindow.height; ++y)
    for (std::uint32_t x = 0; x < kWindow.width; ++x) {
      const bool inside = x >= 20 && x < 220 && y >= 30 && y < 130;
      ASSERT_FALSE(differs(x, y) && !inside) << x << ", " << y;
    }
}

TEST_F(PreviewWindow, ReportsKeys) {
  open();
  std::vector<Key> pressed;
  for (const char* key : {"w", "1", "F1", "space", "bracketleft", "minus", "Escape"}) screen_.tap(key);
  screen_.press("d");
  Input last;
  EXPECT_TRUE(poll_until([&](const Input& input) {
    pressed.insert(pressed.end(), input.pressed.begin(), input.pressed.end());
    last = input;
    return input.holds(Key::D);
  }));
  EXPECT_EQ(pressed, (std::vector<Key>{Key::W, Key::Digit1, Key::F1, Key::Space, Key::LeftBracket, Key::Minus,
                                       Key::Escape, Key::D}));
  EXPECT_FALSE(last.holds(Key::W));
  screen_.release("d");
  EXPECT_TRUE(poll_until([](const Input& input) { return !input.holds(Key::D); }));
}

TEST_F(PreviewWindow, ReportsDragsAndTheWheel) {
  open();
  glm::dvec2 dragged{0, 0};
  double scrolled = 0;
  const auto add = [&](const Input& input) {
    dragged += input.drag_px;
    scrolled += input.scroll;
  };
  screen_.move_mouse(id_, 100, 100);
  screen_.move_mouse(id_, 300, 200);
  screen_.press_button();
  screen_.move_mouse(id_, 330, 180);
  screen_.release_button();
  screen_.move_mouse(id_, 400, 400);
  for (const unsigned wheel : {4u, 4u, 5u}) {
    screen_.press_button(wheel);
    screen_.release_button(wheel);
  }
  screen_.tap("q");
  EXPECT_TRUE(poll_until([&](const Input& input) {
    add(input);
    return !input.pressed.empty();
  }));
  EXPECT_EQ(dragged, glm::dvec2(30, -20));
  EXPECT_EQ(scrolled, 1);
}

TEST_F(PreviewWindow, LeavesInputOverThePanelToThePanel) {
  open();
  const auto panel = [] {
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({200, 200});
    ImGui::Begin("panel");
    ImGui::End();
  };
  EXPECT_TRUE(screen_.wait_until([&] {
    window_->poll();
    presenter_->show({}, panel);
    return ImGui::GetFrameCount() >= 3;
  }));
  // The button is pressed before ImGui has received the mouse position.
  screen_.move_mouse(id_, 100, 100);
  screen_.press_button();
  screen_.move_mouse(id_, 150, 150);
  screen_.release_button();
  screen_.tap("q");
  glm::dvec2 dragged{0, 0};
  EXPECT_TRUE(poll_until([&](const Input& input) {
    dragged += input.drag_px;
    return !input.pressed.empty();
  }));
  EXPECT_EQ(dragged, glm::dvec2(0, 0));
}

TEST_F(PreviewWindow, ReportsThatItShouldClose) {
  open();
  EXPECT_FALSE(window_->should_close());
  screen_.close(id_);
  EXPECT_TRUE(poll_until([&](const Input&) { return window_->should_close(); }));
}

TEST_F(PreviewWindow, ShowsNothingWhileMinimisedAndContinuesAfterwards) {
  screen_.manage_windows();
  open();
  on_screen({});
  screen_.iconify(id_);
  EXPECT_TRUE(poll_until([&](const Input&) { return window_->framebuffer_size() == Extent{}; }));
  EXPECT_EQ(presenter_->show({}, [] { ADD_FAILURE() << "no panel is drawn"; }), Presenter::Outcome::NotNow);
  EXPECT_EQ(presenter_->read_back({}), Image<Rgb8>());
  screen_.restore(id_);
  EXPECT_TRUE(poll_until([&](const Input&) { return window_->framebuffer_size() == kWindow; }));
  EXPECT_EQ(on_screen({}).size, kWindow);
}

/// Prints the time to show a frame. The limit only detects waiting for the display, and is one of the lower
/// quartile, because a busy machine holds some frames up.
TEST_F(PreviewWindow, ShowingCostsAFewMilliseconds) {
  open(gpu::Validation::Off);
  screen_.move_mouse(id_, 1000, 500);  // hands off the panel
  const auto figures = [] {
    ImGui::Begin("panel");
    for (int line = 0; line < 20; ++line) ImGui::Text("a line of figures, number %d: %f", line, line * 0.1);
    ImGui::End();
  };
  const auto time = [&](const char* what, StereoLayout layout, const std::function<void()>& panel) {
    constexpr int frames = 100;
    std::vector<double> wall_ms;
    const std::clock_t start = std::clock();
    for (int i = 0; i < frames; ++i) {
      const Stopwatch watch;
      window_->poll();
      presenter_->show({.layout = layout}, panel);
      device_->logical.waitIdle();
      wall_ms.push_back(ms_of(watch.elapsed()));
    }
    const double cpu_ms = static_cast<double>(std::clock() - start) * 1000 / CLOCKS_PER_SEC / frames;
    std::ranges::sort(wall_ms);
    std::printf("%s: %.2f ms until the device is idle (least %.2f), %.2f ms of processor time\n", what,
                wall_ms[frames / 2], wall_ms[0], cpu_ms);
    EXPECT_LT(wall_ms[frames / 4], 200);
  };
  time("mono, no panel", StereoLayout::Mono, no_panel);
  time("mono", StereoLayout::Mono, figures);
  time("side by side, no panel", StereoLayout::SideBySide, no_panel);
  time("side by side", StereoLayout::SideBySide, figures);
  time("anaglyph", StereoLayout::Anaglyph, figures);
}

TEST(OpenWindow, KnowsTheRoomOnTheDesktop) {
  Desktop desktop;
  const auto window = value_of(open_window(kTitle, [&](const Desktop& here) {
    desktop = here;
    return first_window({2048, 2048}, here, {});
  }));
  EXPECT_EQ(desktop.room, (Extent{1600, 900})) << "the whole screen: there is no window manager";
  EXPECT_EQ(window->framebuffer_size(), desktop.room);
  EXPECT_EQ(window->text_scale(), 1);
}

TEST(OpenWindow, NamesTheCureWithoutADesktop) {
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const auto window = open_window(kTitle, of_window);
  setenv("DISPLAY", Screen::get().display().c_str(), 1);
  ASSERT_FALSE(window);
  EXPECT_EQ(window.error().fault, Fault::Missing);
  for (const char* cure : {"DISPLAY", "ssh -X", "xvfb-run -a", "--preview"})
    EXPECT_NE(window.error().what.find(cure), std::string::npos) << cure << ": " << window.error().what;
}

TEST(OpenWindow, NamesTheReasonIfTheDisplayDoesNotAnswer) {
  unsetenv("WAYLAND_DISPLAY");
  setenv("DISPLAY", ":65000", 1);
  const auto window = open_window(kTitle, of_window);
  setenv("DISPLAY", Screen::get().display().c_str(), 1);
  ASSERT_FALSE(window);
  EXPECT_EQ(window.error().fault, Fault::Missing);
  EXPECT_NE(window.error().what.find("cannot open a window on the desktop (DISPLAY=:65000): "),
            std::string::npos)
      << window.error().what;
}

}  // namespace
}  // namespace farshade
