// Measures what the preview adds to a frame. It compares drawing both eyes offscreen with drawing, composing
// and presenting them with the panel in a window on this program's own X server. Each pose is drawn both
// ways; the order alternates. Each frame ends when the device is idle, so that no work is hidden between two
// frames.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <deque>

#include "stereo/base/heap.h"
#include "stereo/base/quantile.h"
#include "stereo/frame/tiles.h"
#include "stereo/gltf/gltf.h"
#include "stereo/gpu/device.h"
#include "stereo/head/reader.h"
#include "stereo/requests/request_plan.h"
#include "tests/preview/x_screen.h"
#include "vr_client/preview/panel.h"
#include "vr_client/preview/presenter.h"

namespace farshade {
namespace {

constexpr std::uint32_t kLate_frames = 2, kWarmUp_frames = 12, kRing_frames = 16;
constexpr Duration kPeriod(1'000'000'000 / 72);

struct BenchOptions {
  std::filesystem::path scene = FARSHADE_ASSETS "/room.glb", trace = FARSHADE_ASSETS "/walk.csv";
  std::uint32_t side_px = 512, frames = 60;
};

/// A traced frame with its request.
struct Traced {
  FrameRequest request;
  ShadowFrame frame;
  PerEye<ReceivedTiles> known;
};

Traced trace(Tracer& tracer, const FrameRequest& request) {
  Traced traced{request, {}, {}};
  tracer.trace(request, traced.frame);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    traced.known[eye].assign(TileGrid{request.views[eye].size}.count(),
                             all_planes_received(traced.frame.masks[eye].layout()));
  return traced;
}

std::vector<TracedMask> usable_masks(const std::deque<Traced>& all, FrameId shown) {
  std::vector<TracedMask> masks;
  for (auto traced = all.rbegin(); traced != all.rend() && masks.size() < kMaxMasks; ++traced)
    if (traced->request.frame.value + kLate_frames <= shown.value)
      masks.push_back({traced->request.frame, traced->request.display_time, traced->request.scene_time,
                       traced->request.views, traced->frame.masks, traced->known, 1});
  return masks;
}

template <class T>
T value_of(Expected<T> value) {
  if (!value) throw std::runtime_error(value.error().what);
  return std::move(*value);
}

void print(const char* label, const std::vector<double>& values) {
  std::printf("  %-34s %9.2f %9.2f %9.2f\n", label, quantile(values, 0.5), quantile(values, 0.1),
              quantile(values, 0.95));
}

struct Times {
  std::vector<double> offscreen, previewed, added;
};

void print_times(const Scene& scene, const BenchOptions& options, const gpu::Device& device,
                 const Times& times) {
  std::printf("%s along %s on %s, %zu + %zu frames\n", scene.name.c_str(), options.trace.c_str(),
              device.name.c_str(), times.offscreen.size(), times.previewed.size());
  std::printf("  %-34s %9s %9s %9s\n", "ms", "median", "p10", "p95");
  print("frame, offscreen", times.offscreen);
  print("frame, in a window with panel", times.previewed);
  print("  composing and presenting", times.added);
  std::printf("preview / offscreen = %.3f (figure: <= 1.10)\n",
              quantile(times.previewed, 0.5) / quantile(times.offscreen, 0.5));
}

/// Room for both eyes and the panel.
SizeOnDesktop window_for(Extent eye) {
  return [eye](const Desktop&) { return Extent{eye.width * 2 + 330, std::max(eye.height, 720u)}; };
}

const std::optional<PixelFacts> kNoPixel;

void compare(const BenchOptions& options) {
  const XScreen screen;
  const Extent size{options.side_px, options.side_px};
  const auto window = value_of(open_window("Farshade", window_for(size)));
  const Scene scene = value_of(load_scene(options.scene));
  const HeadRecording head = value_of(load_head_recording(options.trace));
  gpu::DeviceOptions device_options;
  device_options.presentation = window->presentation();
  const gpu::Device device = value_of(gpu::open_device(device_options));
  const auto renderer = make_renderer(device, scene, {size, largest_traced(size), kRing_frames});
  Presenter presenter(device, *window, renderer->shown());
  Tracer tracer = value_of(Tracer::create(scene));
  const auto placed = scene.camera ? place(head, *scene.camera) : Rigid<Stage, Recorded>{};
  Controls controls;
  const History history;
  const SceneState state = state_at(scene, Time{});
  const ControlContext context{state.light_set, {}, nullptr};
  const PanelFacts facts{.history = history,
                         .scene = scene,
                         .context = context,
                         .device = device.name,
                         .server = "server",
                         .note = {},
                         .pixel = kNoPixel,
                         .window = window->framebuffer_size(),
                         .scale = window->text_scale()};
  const Composition composition{.right_px = panel_width_px(controls, facts.window, facts.scale)};
  RequestPlan plan(RequestSettings{});
  plan.learn(kPeriod * kLate_frames);
  std::deque<Traced> traced;
  std::vector<double> offscreen, previewed, added;
  for (std::uint32_t number = 1; number <= options.frames + kWarmUp_frames; ++number) {
    const Time at = head.start() + kPeriod * number;
    const Headset headset{head.eye_distance_m, head.fov, size};
    const FrameMoment shown{{number}, at, {}, views_of(placed * head_at(head, at), headset), {}};
    const FrameRequest request = plan.ask(shown, kPeriod, SceneClock::Paused).value();
    traced.push_back(trace(tracer, request));
    if (traced.size() > kRing_frames / 2) traced.pop_front();
    const std::vector<TracedMask> masks = usable_masks(traced, shown.frame);
    window->poll();
    // Each pose is drawn offscreen and in the window; the order alternates.
    for (const bool shows : {number % 2 == 0, number % 2 == 1}) {
      const Stopwatch frame;
      renderer->draw({.views = shown.views,
                      .state = state,
                      .request = &request,
                      .masks = masks,
                      .reprojection = {},
                      .request_slot = request.frame.value % kRing_frames});
      renderer->submit();
      const Stopwatch showing;
      if (shows) presenter.show(composition, [&] { draw_panel(controls, facts); });
      device.logical.waitIdle();
      if (number <= kWarmUp_frames) continue;  // shaders are compiled on first use
      (shows ? previewed : offscreen).push_back(ms_of(frame.elapsed()));
      if (shows) added.push_back(ms_of(showing.elapsed()));
    }
  }
  print_times(scene, options, device, {offscreen, previewed, added});
}

}  // namespace
}  // namespace farshade

int main(int argc, char** argv) try {
  farshade::keep_freed_memory();
  farshade::BenchOptions options;
  CLI::App app("Measures the time that the preview adds to a frame.");
  app.add_option("--scene", options.scene);
  app.add_option("--trace", options.trace);
  app.add_option("--size", options.side_px, "pixels a side of an eye")->capture_default_str();
  app.add_option("--frames", options.frames)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  farshade::compare(options);
} catch (const std::exception& error) {
  std::fprintf(stderr, "preview_bench: %s\n", error.what());
  return 1;
}
