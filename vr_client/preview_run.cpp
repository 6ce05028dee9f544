#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <thread>
#include <utility>

#include "stereo/base/files.h"
#include "stereo/base/stages.h"
#include "stereo/base/stop_signal.h"
#include "stereo/head/reader.h"
#include "stereo/video/video.h"
#include "vr_client/app.h"
#include "vr_client/client.h"
#include "vr_client/compile_ahead.h"
#include "vr_client/frame_window.h"
#include "vr_client/modes/run_frames.h"
#include "vr_client/placed_head.h"
#include "vr_client/report/timeline.h"

namespace farshade {
namespace {

static_assert(kWorstPath.latency_ms + kWorstPath.jitter_ms <= kWorstPreviewPath_ms);

/// Interval between polls of a minimised window, and between the pictures of a held frame.
constexpr Duration kMinimisedWait = std::chrono::milliseconds(100), kHeldWait = kMinimisedWait;

Rigid<Stage, Head> start_of(const Options& options, const Scene& scene) {
  const Rigid<Stage, Eye> viewpoint = viewpoint_of(scene, options.start_pose);
  return {viewpoint.rotation, viewpoint.translation};
}

PreviewSetup setup_of(const Options& options, const Scene& scene, const std::optional<PlacedHead>& head) {
  PreviewSetup setup{.start = start_of(options, scene),
                     .recording = {},
                     .refresh_hz = options.refresh_hz,
                     .frames = options.frames};
  if (head) setup.recording.emplace(PlacedHeadRecording{head->recording, head->stage_from_recorded});
  return setup;
}

/// The modes that this build can run. Whether the server gives what a mode needs is known once it is asked.
std::vector<Mode> modes_here() {
  std::vector<Mode> modes;
  for (const ModeName& one : kModes)
    if (has_video() || (one.mode != Mode::Remote && one.mode != Mode::Delta)) modes.push_back(one.mode);
  return modes;
}

Controls first_controls(const Options& options, const std::optional<PlacedHead>& head,
                        const Remembered& remembered) {
  Controls controls;
  recall(remembered, controls);
  controls.mode = options.mode.mode;
  controls.modes = modes_here();
  controls.settings.request = options.request;
  controls.settings.reprojection = options.reprojection;
  if (head) {
    controls.head = HeadSource::Recording;
    controls.eye_distance_m = head->recording.eye_distance_m;
    controls.recorded_fov = head->recording.fov;
  }
  return controls;
}

/// In the title, because the window has no frames yet.
void tell_waiting(Window& window, const std::string& what) {
  window.set_title(fmt::format("{} ({})", kTitle, what));
}

/// One preview, from opening to closing its window.
class Preview {
 public:
  /// The reference tracer is created when it is first needed.
  Preview(const Options& options, Client& client, Window& window, StopSignal& stop_signal,
          const std::optional<PlacedHead>& head, const LinkModel& path, const Remembered& remembered,
          Stages& stages)
      : options_(options),
        client_(client),
        window_(window),
        stop_signal_(stop_signal),
        stages_(stages),
        controls_(first_controls(options, head, remembered)),
        path_(path),
        lights_(state_at(client.scene, {}).light_set),
        runtime_(
            setup_of(options, client.scene, head), client.clock,
            [](Duration span) { std::this_thread::sleep_for(span); }, [this] { return read_controls(); }),
        recordings_(options.out, client.clock),
        shown_(client, window, controls_, recordings_, options.size) {
    controls_.path = {ms_of(path_.delay), ms_of(path_.jitter), path_.loss * 100};
    if (Player* const player = runtime_.player()) {
      player->set_at_end(AtEnd::Loop);
      player->scrub(duration_from_ms(options.skip_s * 1e3));
    }
  }

  /// Runs the frame loop until the preview ends. Another mode restarts the loop, and so does a capture,
  /// because it must contain all messages of its session. Both begin a new session.
  Expected<void> run_all() {
    // An empty timeline is written first, so that a path that cannot be written fails early.
    if (auto written = timeline_.write(options_.timeline); !written) return written;
    const bool captures = !options_.record.empty();
    Expected<void> done = open_link(options_, client_, captures ? recordings_.listen() : LinkListener{});
    if (!done) return done;
    settle_exposure(options_, client_);
    if (captures) recordings_.begin_capture(options_.record, header_of(options_, client_));
    if (captures && !recordings_.writes_capture()) return {};  // finish() returns the error
    do {
      if (restart_ != Restart::No) done = restart();
      const auto stop = [&] { return ended() || restart_ != Restart::No; };
      if (done) done = run_once(stop);
    } while (done && restart_ != Restart::No && !ended());
    return done;
  }

  [[nodiscard]] Expected<void> run_once(const std::function<bool()>& stop) {
    return run_frames(
        {.context = [this] { return context_of(options_, client_, runtime_, controls_.settings); },
         .clear = [this] { leave_device(); },
         .reopen = [this] { return take_device(); }},
        [this](const FrameView& view) { watch(view); }, stop);
  }

  [[nodiscard]] Expected<void> finish() {
    const Expected<void> taken = recordings_.finish();
    const Expected<void> written = timeline_.write(options_.timeline);
    remember();
    return taken ? written : taken;
  }

 private:
  [[nodiscard]] bool ended() {
    return quit_ == Quit::Wanted || window_.should_close() || stop_signal_.has_come();
  }
  [[nodiscard]] ControlContext context() { return {lights_, runtime_.stage_from_head(), runtime_.player()}; }

  /// A layout that cannot be kept is no reason to fail.
  void remember() const {
    Remembered remembered = remembered_of(controls_);
    remembered.window = last_size_;
    if (const Expected<void> saved = save_remembered(remembered_path(), remembered); !saved)
      spdlog::warn("the layout of the preview is not remembered: {}", saved.error().what);
  }

  /// A capture ends, because a replay loses no device.
  void leave_device() {
    client_.clock.resume();  // the frame that was held is gone
    end_capture();
    shown_.leave_device();
    client_.renderer.reset();
  }
  Expected<void> take_device() {
    tell_waiting(window_, "opening the GPU again");
    if (auto done = reopen_device(options_, client_); !done) return done;
    shown_.take_device();
    compile();
    return {};
  }

  Expected<void> restart() {
    shown_.forget();
    return std::exchange(restart_, Restart::No) == Restart::Mode ? switch_mode() : restart_with_capture();
  }

  /// Goes back to the present mode, and offers the wanted one no more, if that cannot be run.
  Expected<void> switch_mode() {
    const Mode before = options_.mode.mode, wanted = controls_.mode;
    end_capture();
    const Expected<void> opened = open_mode(wanted);
    trouble_ = opened ? "" : fmt::format("no mode {}: {}", name_of(wanted), opened.error().what);
    if (opened) return {};
    spdlog::warn(trouble_);
    std::erase(controls_.modes, wanted);
    controls_.mode = before;
    return open_mode(before);
  }

  /// Opens what the frames of a mode need: renderer, tracer and session.
  Expected<void> open_mode(Mode mode) {
    options_.mode.mode = mode;
    client_.link.reset();
    client_.device.logical.waitIdle();
    if (auto done = reopen_renderer(options_, client_, kWidestEyes_m); !done) return done;
    shown_.take_renderer();
    if (auto done = open_tracers(options_, mode, client_); !done) return done;
    compile();
    if (answers_for(mode) == 0) return {};
    if (client_.network) return connect(options_, client_);
    followed_.reset();
    return open_link(options_, client_);
  }

  /// The pipelines that the frames of the present mode can need.
  void compile() {
    if (draws_scene(options_.mode.mode))
      compile_ahead(client_, controls_.settings.reprojection, controls_.settings.report, Changes::Possible,
                    [this](const std::string& what) { tell_waiting(window_, what); });
  }

  void end_capture() {
    if (!recordings_.writes_capture()) return;
    recordings_.end_capture();
    follow_capture();
    if (client_.link) client_.link->tell({});  // requests may be for parts again
  }

  Expected<void> restart_with_capture() {
    client_.renderer->forget();
    LinkListener listener = recordings_.listen();
    if (client_.link)
      if (auto connected = connect(options_, client_, std::move(listener)); !connected) return connected;
    settle_exposure(options_, client_);
    recordings_.begin_capture({}, header_of(options_, client_));
    follow_capture();
    return {};
  }

  /// A capture does not hold edge rays.
  void follow_capture() {
    const bool is_captured = recordings_.writes_capture() && options_.reprojection.edges == Edges::Exact;
    controls_.settings.reprojection.edges = is_captured ? Edges::Line : options_.reprojection.edges;
  }

  /// Applies the input since the last frame. Returns nothing to end or restart the run.
  std::optional<HeadControls> read_controls() {
    while (window_.framebuffer_size().pixels() == 0 && !ended()) {
      window_.wait(kMinimisedWait);
      keeper_.keep(client_);
    }
    const Input input = take_input();
    if (ended() || restart_ != Restart::No) return std::nullopt;
    return HeadControls{controls_.head, head_input(input), headset_of(controls_, options_.size)};
  }

  Input take_input() {
    Input input = window_.poll();
    if (const Extent size = window_.framebuffer_size(); size.pixels() > 0) last_size_ = size;
    apply_input(input, controls_, context());
    follow_path();
    toggle_recordings();
    if (controls_.mode != options_.mode.mode) restart_ = Restart::Mode;
    if (controls_.take(Command::Quit)) quit_ = Quit::Wanted;
    return input;
  }

  void follow_path() {
    if (client_.simulator == nullptr || followed_ == controls_.path) return;
    followed_ = controls_.path;
    client_.simulator->follow(path_of(controls_.path, path_));
  }

  void toggle_recordings() {
    if (controls_.take(Command::RecordHead)) recordings_.toggle_head();
    if (controls_.take(Command::RecordFrames)) recordings_.toggle_frames();
    if (!controls_.take(Command::RecordCapture)) return;
    if (recordings_.writes_capture())
      end_capture();
    else if (can_be_captured(options_.mode.mode))
      restart_ = Restart::Capture;
    else
      recordings_.refuse_capture(name_of(options_.mode.mode));
  }

  /// Inspects, records and shows a frame that was drawn. Holds it if the viewer wishes.
  void watch(const FrameView& view) {
    lights_ = view.state.light_set;
    if (view.finished) runtime_.learn_ready(view.times.ready);
    shown_.begin();
    show(view);
    Inspection& inspection = shown_.inspection();
    recordings_.watch(view, recordings_.writes_capture() ? &inspection.shown() : nullptr,
                      recordings_.records_frames() ? &inspection.displayed() : nullptr);
    follow_capture();  // it may have failed
    if (!options_.timeline.empty()) timeline_.add(view, client_.link ? &client_.link->receiver() : nullptr);
    shown_.add(view, options_.mode.mode);
    if (!std::exchange(started_, true)) {
      stages_.end("first frame");
      spdlog::info("the first frame was shown after {}", stages_.in_words());
    }
    // A frame that was drawn before the viewer's wish has no report.
    if (view.settings.report == PixelReport::On) hold(view);
  }

  void show(const FrameView& view) {
    Inspection& inspection = shown_.inspection();
    inspection.inspect(view, controls_, view.as == ShownAs::Picture ? nullptr : reference());
    if (const auto& pictures = inspection.replacement())
      shown_.replace(*pictures);
    else
      shown_.show_eyes();
    const Composition composition = shown_.compose(view);
    if (controls_.take(Command::Screenshot))
      recordings_.take_screenshot(inspection.displayed(), shown_.read_back(composition));
    shown_.show(composition, {context(), options_.mode.mode, trouble_}, shown_.inspected(view, composition));
  }

  /// Shows the frame again and again until the time runs or the next frame is wanted. Settings can change
  /// meanwhile; those of the overlays at once, the others have effect from the next frame on.
  void hold(const FrameView& view) {
    const auto is_held = [&] {
      return controls_.held && !controls_.take(Command::NextFrame) && restart_ == Restart::No && !ended();
    };
    client_.clock.stop();
    while (is_held()) {
      window_.wait(kHeldWait);
      keeper_.keep(client_);
      static_cast<void>(take_input());
      show(view);
    }
    client_.clock.resume();
  }

  /// Null if the controls need no reference. If it cannot be created, the controls that need it are reset.
  Reference* reference() {
    if (!needs_reference(controls_)) return nullptr;
    if (const Expected<void> opened = open_reference(client_); opened) return client_.reference.get();
    controls_.reference = false;
    if (controls_.display == DisplayMode::Difference) controls_.display = DisplayMode::SideBySide;
    if (controls_.overlay == Overlay::Error) controls_.overlay = Overlay::None;
    return nullptr;
  }

  Options options_;  ///< with the present mode
  Client& client_;
  Window& window_;
  StopSignal& stop_signal_;
  Stages& stages_;  ///< of the start
  bool started_ = false;
  Controls controls_;
  LinkModel path_;  ///< from the command line
  std::optional<NetworkSettings> followed_;
  LightSet lights_;  ///< of the last shown frame
  PreviewRuntime runtime_;
  Recordings recordings_;
  FrameWindow shown_;
  Timeline timeline_;
  SessionKeeper keeper_;
  std::optional<Extent> last_size_;  ///< of the window while it was visible
  std::string trouble_;              ///< why the wanted mode is not shown
  enum class Restart : std::uint8_t { No, Capture, Mode } restart_ = Restart::No;
  enum class Quit : std::uint8_t { No, Wanted } quit_ = Quit::No;
};

/// Empty without --trace.
Expected<std::optional<HeadRecording>> recording_of(const Options& options) {
  if (options.trace.empty()) return std::nullopt;
  return load_head_recording(options.trace, options.trace_reading).map([](HeadRecording&& loaded) {
    return std::optional(std::move(loaded));
  });
}

}  // namespace

Expected<void> run_preview(const Options& given, StopSignal& stop) {
  Options options = given;
  options.pace = Pace::Real;
  options.delay_ms = 0;  // for the virtual clock
  Stages stages(kSteadyClock);
  if (auto done = make_folder(options.out); !done) return done;
  Expected<std::optional<HeadRecording>> recording = recording_of(options);
  if (!recording) return tl::unexpected(recording.error());
  const Expected<LinkModel> path = options.net.empty() ? LinkModel{} : parse_link_model(options.net);
  if (!path) return tl::unexpected(path.error());
  const Remembered remembered = recalled();
  const Expected<std::unique_ptr<Window>> window = open_window(
      kTitle, [&](const Desktop& desktop) { return first_window(options.size, desktop, remembered.window); });
  if (!window) return tl::unexpected(window.error());
  stages.end("head and window");
  const TellWaiting tell = [&](const std::string& what) { tell_waiting(**window, what); };
  tell("loading the scene");
  options.device.presentation = (*window)->presentation();
  // The viewer may change the eye distance at any time.
  Expected<std::unique_ptr<Client>> client = open_client(options, needs_of(options, kWidestEyes_m), stages);
  if (!client) return tl::unexpected(client.error());
  std::future<Expected<PlacedHead>> placing;
  const std::future<void> judging =
      *recording ? std::future<void>() : judge_start_meanwhile(options, (*client)->scene);
  if (*recording) placing = place_meanwhile(options, (*client)->scene, **std::move(recording));
  const auto compile = [&] {
    if (draws_scene(options.mode.mode))
      compile_ahead(**client, options.reprojection, PixelReport::Off, Changes::Possible, tell);
  };
  const Mode mode = options.mode.mode;
  if (auto done = open_drawing(options, mode, **client, renderer_limits(options), stages, compile); !done)
    return done;

  std::optional<PlacedHead> head;
  if (placing.valid()) {
    Expected<PlacedHead> placed = placing.get();
    if (!placed) return tl::unexpected(placed.error());
    head = std::move(*placed);
    stages.end("head and window");
  }

  Expected<void> done, finished;
  {
    Preview preview(options, **client, **window, stop, head, *path, remembered, stages);
    try {
      done = preview.run_all();
    } catch (const std::exception& error) {
      // For example a lost surface. The recordings are finished below.
      done = fail(Fault::Unavailable, fmt::format("drawing on {} failed ({}); start again",
                                                  (*client)->device.name, error.what()));
    }
    finished = preview.finish();
  }
  if (done) done = finished;
  if (done) done = no_validation_messages((*client)->device);
  if (done && stop.has_come())
    return fail(Fault::Interrupted, "interrupted; recordings are finished in " + options.out.string());
  return done;
}

}  // namespace farshade
