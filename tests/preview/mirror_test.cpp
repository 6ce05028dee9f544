// A frame loop as a headset has it, with a mirror that watches it: the window shows the renderer's pictures,
// and no state of the window holds the loop up.
#include "vr_client/mirror.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "stereo/base/quantile.h"
#include "tests/preview/x_screen.h"
#include "vr_client/modes/make_pipeline.h"
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

/// A head that stands still, in a headset whose eyes differ.
class StillHead final : public Runtime {
 public:
  explicit StillHead(const Scene& scene) {
    const Rigid<Stage, Eye> start = viewpoint_of(scene, std::nullopt);
    Headset headset;
    headset.eye_size = kEye;
    const double up_rad = std::atan((std::tan(0.8) + std::tan(0.7)) / 2);  // pixels are square
    headset.fov = {EyeFov{-0.8, 0.7, up_rad, -up_rad}, EyeFov{-0.7, 0.8, up_rad, -up_rad}};
    views_ = views_of({start.rotation, start.translation}, headset);
  }
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override {
    now_ += kPeriod;
    return FrameTiming{now_, kPeriod};
  }
  [[nodiscard]] StereoView locate_views(Time) override { return views_; }

 private:
  StereoView views_;
  Time now_{};
};

/// Each test has a screen of its own, because some start a window manager.
class MirrorTest : public testing::Test {
 protected:
  enum class Desktop : std::uint8_t { Here, None };

  void open(Desktop desktop = Desktop::Here, gpu::Validation validation = gpu::Validation::On) {
    options_.scene = FARSHADE_ASSETS "/room.glb";
    options_.out =
        std::filesystem::path(testing::TempDir()) / ("farshade_mirror." + screen_.display().substr(1));
    options_.size = kEye;
    options_.detail_px = 0;
    options_.mode.mode = Mode::Full;
    options_.reference_every = 0;
    options_.device.name_contains = "llvmpipe";
    options_.device.validation = validation;
    std::unique_ptr<Window> window;
    if (desktop == Desktop::Here) {
      window = value_of(open_window(kTitle, [](const farshade::Desktop&) { return kSnug; }));
      options_.device.presentation = wished_presentation(*window);
      if (!presents_) options_.device.presentation->can_present = [](auto...) { return false; };
    }
    Stages stages(kSteadyClock);
    client_ = value_of(open_client(options_, needs_of(options_, 0.063), stages));
    if (const auto traces = open_tracers(options_, Mode::Full, *client_); !traces)
      throw std::runtime_error(traces.error().what);
    open_renderer(options_, *client_, renderer_limits(options_));
    controls_ = headset_controls(options_, PixelReport::Off);
    controls_.panel = false;
    controls_.settings.scene = SceneClock::Paused;
    mirror_ = std::make_unique<Mirror>(options_, *client_, std::move(window), controls_);
    head_.emplace(client_->scene);
    if (desktop == Desktop::None || !presents_) return;
    id_ = screen_.wait_for(kTitle).value();
    screen_.focus(id_);
  }

  void TearDown() override {
    mirror_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(options_.out, ignored);
    if (!client_ || !client_->device.validation_log) return;
    for (const std::string& message : client_->device.validation_log->messages()) ADD_FAILURE() << message;
  }

  /// Runs the frame loop until `stop` returns true. Returns the times of the mirror's calls, ms.
  std::vector<double> run_until(const std::function<bool()>& stop) {
    const RunContext context{.scene = client_->scene,
                             .runtime = *head_,
                             .renderer = *client_->renderer,
                             .mode = options_.mode,
                             .own_tracer = client_->own_tracer.get(),
                             .settings = controls_.settings,
                             .policy = {.pace = Pace::Real}};
    std::vector<double> took_ms;
    const auto watch = [&](const FrameView& view) {
      const Stopwatch stopwatch;
      mirror_->watch(view);
      took_ms.push_back(ms_of(stopwatch.elapsed()));
      shown_ = client_->renderer->read_shown();
      inspection_.begin(*client_->renderer);
      inspection_.inspect(view, controls_, nullptr);
    };
    const Expected<void> done = run(context, *make_pipeline(context), watch, stop);
    EXPECT_TRUE(done);
    return took_ms;
  }
  /// Until the condition holds; for three minutes at most.
  bool runs_until(const std::function<bool()>& holds) {
    bool held = false;
    const Stopwatch stopwatch;
    run_until([&] { return (held = holds()) || stopwatch.elapsed() > std::chrono::minutes(3); });
    return held;
  }
  std::vector<double> run_frames(std::size_t count) {
    std::size_t frames = 0;
    return run_until([&] { return frames++ == count; });
  }

  /// Whether the halves of the window are these pictures.
  bool shows(const PerEye<Image<Rgb8>>& pictures) {
    const Image<Rgb8> seen = screen_.screenshot(id_);
    if (seen.size != kSnug || pictures[0].size != kEye) return false;
    for (std::uint32_t eye = 0; eye < kEyes; ++eye)
      for (std::uint32_t y = 0; y < kEye.height; ++y)
        for (std::uint32_t x = 0; x < kEye.width; ++x)
          if (seen.at(eye * kSnug.width / 2 + 7 + x, 7 + y) != pictures[eye].at(x, y)) return false;
    return true;
  }

  XScreen screen_;
  Options options_;
  std::unique_ptr<Client> client_;
  Controls controls_;
  std::unique_ptr<Mirror> mirror_;
  std::optional<StillHead> head_;
  PerEye<Image<Rgb8>> shown_;  ///< of the last frame
  Inspection inspection_;      ///< of the last frame
  XScreen::WindowId id_ = 0;
  bool presents_ = true;  ///< the device
};

TEST_F(MirrorTest, ShowsThePicturesOfTheHeadset) {
  open();
  EXPECT_TRUE(runs_until([&] { return shows(shown_); }));
  EXPECT_NE(shown_[0], shown_[1]) << "a swap of the eyes would not be seen";
  EXPECT_EQ(screen_.title_of(id_).find("Farshade: "), 0u) << screen_.title_of(id_);
  const std::uint64_t frames = mirror_->frames();
  EXPECT_GT(frames, 0u);
  mirror_->idle();
  EXPECT_FALSE(mirror_->wants_to_end());
  EXPECT_TRUE(mirror_->finish());
}

TEST_F(MirrorTest, ShowsTheOverlayThatTheControlsChoose) {
  open();
  run_frames(2);
  controls_.overlay = Overlay::Source;  // as a controller's button does
  ASSERT_TRUE(runs_until([&] { return inspection_.replacement() && shows(*inspection_.replacement()); }));
  EXPECT_NE(shown_, *inspection_.replacement());
  screen_.tap("0");
  EXPECT_TRUE(runs_until([&] { return controls_.overlay == Overlay::None && shows(shown_); }));
  EXPECT_EQ(controls_.settings.report, PixelReport::Off);
}

TEST_F(MirrorTest, KeysChangeTheSceneAndLeaveToTheHeadsetWhatIsItsOwn) {
  open();
  for (const char* key : {"h", "Return", "m", "f", "F8", "F10", "bracketright", "plus", "period", "k"})
    screen_.tap(key);
  EXPECT_TRUE(runs_until([&] { return !controls_.settings.lights.lights.empty(); }))
      << "K switches a light off";
  EXPECT_FALSE(controls_.held);
  EXPECT_FALSE(controls_.reference);
  EXPECT_EQ(controls_.mode, Mode::Full);
  EXPECT_EQ(controls_.head, HeadSource::Simulated);
  EXPECT_EQ(controls_.path, NetworkSettings{});
  EXPECT_EQ(controls_.settings.request.every, options_.request.every);
  EXPECT_TRUE(controls_.pending.none());
  EXPECT_FALSE(mirror_->wants_to_end());
  screen_.tap("Escape");
  EXPECT_TRUE(runs_until([&] { return mirror_->wants_to_end(); }));
}

TEST_F(MirrorTest, AWindowThatIsClosedAsksForTheEnd) {
  open();
  run_frames(2);
  EXPECT_FALSE(mirror_->wants_to_end());
  screen_.close(id_);
  EXPECT_TRUE(screen_.wait_until([&] {
    mirror_->idle();
    return mirror_->wants_to_end();
  })) << "also while the headset shows no frames";
  EXPECT_EQ(run_frames(3).size(), 3u) << "frames go on until the session has ended";
}

TEST_F(MirrorTest, WithoutADesktopFramesGoOn) {
  open(Desktop::None);
  EXPECT_EQ(run_frames(3).size(), 3u);
  mirror_->idle();
  EXPECT_FALSE(mirror_->wants_to_end());
  EXPECT_EQ(mirror_->frames(), 0u);
  EXPECT_TRUE(mirror_->finish());
}

TEST_F(MirrorTest, ADeviceThatCannotPresentClosesTheWindow) {
  presents_ = false;
  open();
  EXPECT_FALSE(client_->device.presents);
  EXPECT_EQ(run_frames(3).size(), 3u);
  EXPECT_TRUE(screen_.wait_until([&] { return !screen_.find(kTitle); }));
  EXPECT_FALSE(mirror_->wants_to_end());
}

TEST_F(MirrorTest, AMinimisedWindowIsSkippedAndShownAgainLater) {
  screen_.manage_windows();
  open();
  ASSERT_TRUE(runs_until([&] { return shows(shown_); }));
  screen_.iconify(id_);
  EXPECT_TRUE(runs_until([&] { return !screen_.find(kTitle); }));
  run_frames(5);
  const std::uint64_t before = mirror_->frames();
  run_frames(10);
  EXPECT_EQ(mirror_->frames(), before);
  screen_.restore(id_);
  EXPECT_TRUE(runs_until([&] { return mirror_->frames() > before && shows(shown_); }));
}

/// Prints what the mirror adds to a frame. The limit only detects waiting, and is one of the lower quartile,
/// because a busy machine holds some frames up.
TEST_F(MirrorTest, NoStateOfTheWindowHoldsTheFramesUp) {
  screen_.manage_windows();
  open(Desktop::Here, gpu::Validation::Off);
  ASSERT_TRUE(runs_until([&] { return shows(shown_); }));
  const auto measure = [&](const char* what) {
    const std::vector<double> took_ms = run_frames(100);
    std::printf("%s: a frame takes %.2f ms longer (median; 95 %%: %.2f; most %.2f)\n", what,
                quantile(took_ms, 0.5), quantile(took_ms, 0.95), quantile(took_ms, 1));
    EXPECT_LT(quantile(took_ms, 0.25), 100);
  };
  measure("shown");
  controls_.panel = true;
  measure("shown, with the panel");
  controls_.overlay = Overlay::Source;
  measure("shown, with the panel and an overlay");
  controls_.overlay = Overlay::None;
  controls_.panel = false;
  screen_.cover();
  measure("covered by another window");
  screen_.iconify(id_);
  measure("minimised");
}

}  // namespace
}  // namespace farshade
