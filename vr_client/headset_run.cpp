#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "stereo/base/files.h"
#include "stereo/base/stages.h"
#include "stereo/base/stop_signal.h"
#include "vr_client/app.h"
#include "vr_client/client.h"
#include "vr_client/compile_ahead.h"
#include "vr_client/mirror.h"
#include "vr_client/modes/run_frames.h"
#include "vr_client/openxr/headset_runtime.h"
#include "vr_client/placed_head.h"
#include "vr_client/preview/headset_controls.h"
#include "vr_client/preview/recordings.h"
#include "vr_client/run_outputs.h"
#include "vr_client/summarize.h"

namespace farshade {
namespace {

/// A headset's eyes are never farther apart. Only whether they are apart matters.
constexpr double kEyes_m = 0.08;

/// What a run in a headset writes. Figures and pictures need the number of frames (--frames); a session
/// without an end would fill the memory with them.
class HeadsetReport {
 public:
  HeadsetReport(const Options& options, Client& client, Stages& stages)
      : options_(options), client_(client), outputs_(options, client, stages, measuring_of(options)) {}

  [[nodiscard]] LinkListener listener() { return outputs_.listener(); }
  [[nodiscard]] Expected<void> begin() { return outputs_.begin(); }

  /// `refresh_hz`: of the display. The capture begins with the first frame, because its header states it.
  void watch(const FrameView& view, double refresh_hz) {
    refresh_hz_ = refresh_hz;
    if (frames() == 0) opened_ = outputs_.open_capture(at_display());
    if (options_.frames) views_.push_back(view.shown.views);
    if (!options_.record_head.empty()) head_.add(view.shown.display_time, view.shown.views);
    if (const auto news = outputs_.watch(view)) spdlog::warn(*news);
  }
  void lose_device() { outputs_.lose_device(); }
  [[nodiscard]] std::uint32_t frames() const { return outputs_.frames(); }
  [[nodiscard]] bool failed() const { return !opened_; }
  /// Whether it showed as many frames as --frames says.
  [[nodiscard]] bool is_complete() const { return !options_.frames || frames() >= *options_.frames; }

  /// Writes everything, also after a run that failed. Returns the first failure.
  [[nodiscard]] Expected<void> finish(const HeadsetSystem& system) {
    Expected<void> done = opened_;
    if (!options_.record_head.empty())
      if (auto written = head_.write(options_.record_head); done) done = written;
    const auto conclude = [&] { return frames() > 0 ? summarize_frames(system) : Expected<void>{}; };
    if (auto written = outputs_.finish(!is_complete(), conclude); done) done = written;
    return done;
  }
  [[nodiscard]] Expected<void> answered() const {
    return outputs_.log() && frames() > 0 ? check_answered(client_, *outputs_.log()) : Expected<void>{};
  }

 private:
  static std::optional<RunReportOptions> measuring_of(const Options& options) {
    if (!options.frames) return std::nullopt;
    return report_options(options, *options.frames, Compare::AfterTheRun);
  }
  /// The options with the refresh rate of the display.
  [[nodiscard]] Options at_display() const {
    Options options = options_;
    options.refresh_hz = refresh_hz_;
    return options;
  }
  [[nodiscard]] Expected<void> summarize_frames(const HeadsetSystem& system) const {
    FinishedRun run{.log = *outputs_.log(),
                    .silence = outputs_.silence(),
                    .interrupted = !is_complete(),
                    .head = system.name()};
    if (const auto surroundings = Surroundings::create(client_.scene))
      run.head_test = test_views(*surroundings, views_);
    return summarize(at_display(), client_, run);
  }

  const Options& options_;
  Client& client_;
  RunOutputs outputs_;
  HeadRecordingWriter head_;
  std::vector<StereoView> views_;  ///< of the frames that the figures are about
  double refresh_hz_ = 90;         ///< at the last frame
  Expected<void> opened_{};        ///< the capture
};

/// Whether what the lenses hide is left out. A capture and the comparison with references are about all
/// pixels.
bool hides(const Options& options) {
  return options.record.empty() && options.reference_every == 0;
}

/// The options of a run in this headset. `window` may be null.
Options options_for(const Options& given, const HeadsetSystem& system, const Window* window) {
  Options options = given;
  options.pace = Pace::Real;
  options.delay_ms = 0;  // for the virtual clock
  // A display that does not wait has no time for comparisons, unless the user asks for them.
  if (options.xr == Xr::Auto || !options.frames) options.reference_every = 0;
  if (!options.frames && (!options.json.empty() || !options.dump.empty()))
    spdlog::warn("a session has figures only with --frames; --json and --dump write nothing");
  options.size = system.eye_size(options.xr_scale);
  options.device.maker = system.vulkan();
  if (window) options.device.presentation = wished_presentation(*window);
  return options;
}

void compile(const Options& options, Client& client) {
  if (draws_scene(options.mode.mode))
    compile_ahead(client, options.reprojection, report_of(options), Changes::Possible);
}

/// The client for a headset, without a server. The viewer may move lights.
Expected<std::unique_ptr<Client>> open_for(const Options& options, Stages& stages) {
  Expected<std::unique_ptr<Client>> client = open_client(options, needs_of(options, kEyes_m), stages);
  if (!client) return client;
  return open_drawing(options, options.mode.mode, **client, renderer_limits(options), stages,
                      [&] { compile(options, **client); })
      .map([&] { return std::move(*client); });
}

/// What the frames are drawn on. Keeps the references.
FrameDevice device_of(const Options& options, Client& client, HeadsetRuntime& runtime, Mirror& mirror,
                      HeadsetReport& report, const FrameSettings& settings) {
  return {.context = [&] { return context_of(options, client, runtime, settings); },
          .clear =
              [&] {
                report.lose_device();
                mirror.leave_device();
                runtime.leave_device();
                client.renderer.reset();
              },
          .reopen =
              [&] {
                return reopen_device(options, client).map([&] {
                  compile(options, client);
                  runtime.take_device(client.renderer->shown());
                  mirror.take_device();
                });
              }};
}

/// Runs the frame loop. A device that is lost or has no memory is an error like any other, so that what the
/// frames so far have left is written.
Expected<void> run_once(const FrameDevice& device, const FrameWatcher& watch,
                        const std::function<bool()>& stop) try {
  return run_frames(device, watch, stop);
} catch (const vk::SystemError& failed) {
  return fail(Fault::Unavailable,
              fmt::format("drawing failed ({}): a smaller --xr-scale needs less memory", failed.what()));
}

/// The frames of a session, from the first to its end.
Expected<void> show(const FrameDevice& device, HeadsetRuntime& runtime, const FrameWatcher& watch,
                    const std::function<bool()>& stop) {
  const Expected<void> shown = run_once(device, watch, stop);
  const Expected<void> ended = runtime.finish();
  const HeadsetRuntime::Counters& counters = runtime.counters();
  spdlog::info("the headset showed {} frames and skipped {}; its session was {}", counters.submitted,
               counters.empty, runtime.history());
  return shown ? ended : shown;
}

/// Of a run that has shown its frames and written its files.
Expected<void> outcome(const Options& options, const Client& client, const HeadsetReport& report,
                       bool was_interrupted, bool was_closed) {
  if (auto done = no_validation_messages(client.device); !done) return done;
  if (was_interrupted)
    return fail(Fault::Interrupted, fmt::format("interrupted after {} frames", report.frames()));
  if (!report.is_complete() && !was_closed)
    return fail(Fault::Unavailable, fmt::format("the headset's session ended after {} of {} frames",
                                                report.frames(), *options.frames));
  return report.answered();
}

}  // namespace

Expected<void> run_headset(const Options& given, HeadsetSystem& system, StopSignal& stop) {
  std::unique_ptr<Window> window = open_mirror_window();
  const Options options = options_for(given, system, window.get());
  Stages stages(kSteadyClock);
  spdlog::info("the headset is {}: {}x{} pixels an eye", system.name(), options.size.width,
               options.size.height);
  if (auto done = RunOutputs::prepare(options); !done) return done;
  const Expected<std::unique_ptr<Client>> opened = open_for(options, stages);
  if (!opened) return tl::unexpected(opened.error());
  Client& client = **opened;
  const std::future<void> judging = judge_start_meanwhile(options, client.scene);
  HeadsetReport report(options, client, stages);
  SessionKeeper keeper;
  Controls controls = headset_controls(options, report_of(options));
  ControllerState controllers;
  LightSet lights = state_at(client.scene, {}).light_set;  // of the last shown frame
  Mirror mirror(options, client, std::move(window), controls);
  const auto wants_to_end = [&] {
    return stop.has_come() || report.failed() || mirror.wants_to_end() ||
           (options.frames && report.is_complete());
  };
  const auto depth = [&client]() -> HeadsetDepth {
    const ShownDepth shown = client.renderer->shown_depth();
    return {shown.image, shown.first_layer};
  };
  Expected<std::unique_ptr<HeadsetRuntime>> runtime = system.open_runtime(
      client.device, client.renderer->shown(),
      {.start = viewpoint_of(client.scene, options.start_pose),
       .eye_size = options.size,
       .wants_to_end = wants_to_end,
       .idle =
           [&] {
             keeper.keep(client);
             mirror.idle();
           },
       .depth = draws_scene(options.mode.mode) ? depth : std::function<HeadsetDepth()>{},
       .follow_hands =
           [&](const ViewerInput& input) { return follow_hands(input, controllers, controls, lights); },
       .hides = hides(options)});
  if (!runtime) return tl::unexpected(runtime.error());
  stages.end("headset");
  if (auto done = open_link(options, client, report.listener()); !done) return done;
  if (client.link) client.link->give_up_when([&stop] { return stop.has_come(); });
  if (auto done = report.begin(); !done) return done;
  stages.end("server");

  const auto watch = [&](const FrameView& view) {
    lights = view.state.light_set;
    report.watch(view, (*runtime)->refresh_hz());
    mirror.watch(view);
  };
  Expected<void> done = show(device_of(options, client, **runtime, mirror, report, controls.settings),
                             **runtime, watch, wants_to_end);
  if (auto written = report.finish(system); done) done = written;
  if (auto written = mirror.finish(); done) done = written;
  return done ? outcome(options, client, report, stop.has_come(), mirror.wants_to_end()) : done;
}

}  // namespace farshade
