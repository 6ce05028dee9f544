// A window whose frames are drawn on a device that is lost.
#include "vr_client/frame_window.h"

#include <gtest/gtest.h>

#include "stereo/math/rotation.h"
#include "tests/preview/x_screen.h"
#include "vr_client/modes/run_frames.h"
#include "vr_client/runtime/headset.h"

namespace farshade {
namespace {

/// In this window, each eye is shown unscaled in the middle of its half.
constexpr Extent kEye{96, 96}, kSnug{220, 110};
constexpr Duration kPeriod = std::chrono::milliseconds(11);

template <class T>
T value_of(Expected<T> expected) {
  if (!expected) throw std::runtime_error(expected.error().what);
  return std::move(*expected);
}

Options options_of(const Window& window) {
  Options options;
  options.scene = FARSHADE_ASSETS "/room.glb";
  options.size = kEye;
  options.mode.mode = Mode::Local;
  options.device.name_contains = "llvmpipe";
  options.device.validation = gpu::Validation::On;
  options.device.presentation = window.presentation();
  return options;
}

/// A head that stands still unless the test turns it.
class StillHead final : public Runtime {
 public:
  explicit StillHead(const Scene& scene) : start_(viewpoint_of(scene, std::nullopt)) {}
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override {
    now_ += kPeriod;
    return FrameTiming{now_, kPeriod};
  }
  [[nodiscard]] StereoView locate_views(Time) override {
    Headset headset;
    headset.eye_size = kEye;
    headset.fov.fill(field_of_view(1.5, 1));
    return views_of({start_.rotation * rotation_exp({0, yaw_rad, 0}), start_.translation}, headset);
  }
  double yaw_rad = 0;

 private:
  Rigid<Stage, Eye> start_;
  Time now_{};
};

/// Whether the halves of the window are these pictures.
bool has(const Image<Rgb8>& window, const PerEye<Image<Rgb8>>& pictures) {
  if (window.size != kSnug) return false;
  for (std::uint32_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t y = 0; y < kEye.height; ++y)
      for (std::uint32_t x = 0; x < kEye.width; ++x)
        if (window.at(eye * kSnug.width / 2 + 7 + x, 7 + y) != pictures[eye].at(x, y)) return false;
  return true;
}

TEST(FrameWindow, ShowsTheFramesOfADeviceThatIsOpenedAgain) {
  XScreen screen;
  const std::unique_ptr<Window> window = value_of(open_window(kTitle, [](const Desktop&) { return kSnug; }));
  const Options options = options_of(*window);
  Stages stages(kSteadyClock);
  const std::unique_ptr<Client> client = value_of(open_client(options, needs_of(options, 0.063), stages));
  open_renderer(options, *client, renderer_limits(options));
  Controls controls;
  controls.panel = false;
  Recordings recordings(testing::TempDir(), client->clock);
  FrameWindow shown(*client, *window, controls, recordings, kEye);
  StillHead head(client->scene);
  const XScreen::WindowId id = screen.wait_for(kTitle).value();

  PerEye<Image<Rgb8>> pictures;
  controls.settings.scene = SceneClock::Paused;
  constexpr int kDevices = 3;
  int seen_on = 0, opened = 1;  // the number of the device
  const auto watch = [&](const FrameView& view) {
    shown.begin();
    shown.show_eyes();
    const LightSet lights = view.state.light_set;
    shown.show(shown.compose(view), {{lights, {}, nullptr}, Mode::Local, {}}, std::nullopt);
    pictures = client->renderer->read_shown();
    if (seen_on == opened || !has(screen.screenshot(id), pictures)) return;
    seen_on = opened;
    if (opened < kDevices) client->device.timeout_ns = 1;  // the next frame is not ready in time
  };
  const FrameDevice device{.context =
                               [&] {
                                 return RunContext{.scene = client->scene,
                                                   .runtime = head,
                                                   .renderer = *client->renderer,
                                                   .mode = options.mode,
                                                   .settings = controls.settings,
                                                   .policy = {.pace = Pace::Real}};
                               },
                           .clear =
                               [&] {
                                 shown.leave_device();
                                 client->renderer.reset();
                               },
                           .reopen =
                               [&] {
                                 head.yaw_rad = 0.2 * opened++;  // for other pictures
                                 return reopen_device(options, *client).map([&] { shown.take_device(); });
                               }};
  const Stopwatch stopwatch;
  const Expected<void> done = run_frames(
      device, watch, [&] { return seen_on == kDevices || stopwatch.elapsed() > std::chrono::minutes(3); });
  if (!done) ADD_FAILURE() << done.error().what;
  EXPECT_EQ(seen_on, kDevices) << "each device has shown its pictures";
  for (const std::string& message : client->device.validation_log->messages()) ADD_FAILURE() << message;
}

}  // namespace
}  // namespace farshade
