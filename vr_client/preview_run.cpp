#include "vr_client/preview_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <thread>

#include "stereo/base/files.h"
#include "stereo/base/stop_signal.h"
#include "stereo/head/reader.h"
#include "vr_client/client.h"
#include "vr_client/preview/inspection.h"
#include "vr_client/preview/panel.h"
#include "vr_client/preview/presenter.h"
#include "vr_client/preview/recordings.h"
#include "vr_client/report/timeline.h"

namespace farshade {
namespace {

static_assert(kWorstPath.latency_ms + kWorstPath.jitter_ms <= kWorstPreviewPath_ms);

constexpr const char* kTitle = "Farshade";
constexpr std::uint32_t kFirstPanel_px = 330, kLeastEye_px = 480, kLeastHeight_px = 720;
/// A window opened larger than this would hardly fit a desktop.
constexpr Extent kMostFirstWindow{1860, 1000};
/// A minimised window is looked at so often.
constexpr Duration kMinimisedWait = std::chrono::milliseconds(100);
constexpr Duration kTitleEvery = std::chrono::seconds(1);
/// A server that has said nothing for so long is said to be silent.
constexpr Duration kSilent = std::chrono::seconds(1);
constexpr double kPersonsEyes_m = 1.6;

Rigid<Stage, Head> start_of(const Scene& scene) {
  if (scene.camera) return {scene.camera->rotation, scene.camera->translation};
  const glm::dvec3 low = scene.bounds.low, high = scene.bounds.high;
  return {.translation = {(low.x + high.x) / 2, std::min(low.y + kPersonsEyes_m, (low.y + high.y) / 2),
                          (low.z + high.z) / 2}};
}

double aspect_of(const View& view) {
  const FovTangents window = tangents_of(view.fov);
  return (window.right_tan - window.left_tan) / (window.up_tan - window.down_tan);
}

PreviewSetup setup_of(const Options& options, const Scene& scene, const std::optional<HeadRecording>& trace) {
  PreviewSetup setup{
      .start = start_of(scene), .recording = {}, .refresh_hz = options.refresh_hz, .frames = options.frames};
  const bool placed = options.place == Place::Camera && scene.camera.has_value();
  if (trace)
    setup.recording.emplace(
        PlacedHeadRecording{*trace, placed ? place(*trace, *scene.camera) : Rigid<Stage, Recorded>{}});
  return setup;
}

Controls first_controls(const Options& options, const std::optional<HeadRecording>& trace) {
  Controls controls;
  controls.steering.wish = options.request;
  controls.steering.carry_over = options.carry_over;
  if (trace) {
    controls.head = HeadSource::Recording;
    controls.eye_distance_m = trace->eye_distance_m;
    controls.recorded_fov = trace->fov;
  }
  return controls;
}

/// One preview, from the window's opening to its close.
class Preview {
 public:
  /// The first frames draw without a reference; one is made when it is first needed.
  Preview(const Options& options, Client& client, Window& window, StopSignal& stop_signal,
          const std::optional<HeadRecording>& trace, const LinkModel& path)
      : options_(options),
        client_(client),
        window_(window),
        stop_signal_(stop_signal),
        presenter_(client.device, window, client.renderer->shown()),
        controls_(first_controls(options, trace)),
        path_(path),
        lights_(state_at(client.scene, {}).light_set),
        runtime_(
            setup_of(options, client.scene, trace), client.clock,
            [](Duration span) { std::this_thread::sleep_for(span); }, [this] { return take_in(); }),
        inspection_(*client.renderer),
        takes_(options.out, client.clock) {
    controls_.path = {ms_of(path_.delay), ms_of(path_.jitter), path_.loss * 100};
    if (Player* const player = runtime_.player()) {
      player->set_at_end(AtEnd::Loop);
      player->scrub(duration_from_ms(options.skip_s * 1e3));
    }
  }

  /// Session after session: one that is recorded begins with its recording.
  Expected<void> run_all() {
    // Written once before there is anything in it, to learn early that it cannot be.
    if (auto written = write_timeline(); !written) return written;
    const bool recorded = !options_.record.empty();
    Expected<void> done = open_link(options_, client_, recorded ? takes_.listen() : LinkListener{});
    if (!done) return done;
    if (recorded) takes_.begin_session(options_.record, header_of(options_, client_, policy()));
    if (recorded && !takes_.records_session()) return {};  // finish() says why
    do {
      if (restart_ == Restart::Wanted) done = begin_recorded_session();
      const auto stop = [&] { return ended() || restart_ == Restart::Wanted; };
      if (done)
        done = run(
            session(), [this](const FrameView& view) { watch(view); }, stop);
    } while (done && restart_ == Restart::Wanted && !ended());
    return done;
  }

  [[nodiscard]] Expected<void> finish() {
    const Expected<void> taken = takes_.finish();
    const Expected<void> written = write_timeline();
    return taken ? written : taken;
  }

 private:
  [[nodiscard]] Expected<void> write_timeline() const {
    return options_.timeline.empty() ? Expected<void>{} : timeline_.write(options_.timeline);
  }
  [[nodiscard]] bool ended() {
    return quit_ == Quit::Wanted || window_.should_close() || stop_signal_.has_come();
  }
  [[nodiscard]] ControlState stand() { return {lights_, runtime_.stage_from_head(), runtime_.player()}; }

  [[nodiscard]] MaskPolicy policy() const {
    return {.pace = Pace::Real,
            .round_trip = client_.round_trip,
            .mask_wait = duration_from_ms(options_.mask_wait_ms)};
  }
  [[nodiscard]] RunContext session() {
    return {.scene = client_.scene,
            .runtime = runtime_,
            .renderer = *client_.renderer,
            .mode = options_.mode,
            .link = client_.link ? &*client_.link : nullptr,
            .own_tracer = client_.own_tracer ? &*client_.own_tracer : nullptr,
            .steering = controls_.steering,
            .policy = policy()};
  }

  Expected<void> begin_recorded_session() {
    restart_ = Restart::No;
    history_ = {};
    client_.renderer->forget();
    LinkListener listener = takes_.listen();
    if (client_.link)
      if (auto met = meet(options_, client_, std::move(listener)); !met) return met;
    takes_.begin_session({}, header_of(options_, client_, policy()));
    return {};
  }

  /// What hands did since the last frame, done; nothing ends the session.
  std::optional<HeadControls> take_in() {
    while (window_.framebuffer_size().pixels() == 0 && !ended()) {
      window_.wait(kMinimisedWait);
      if (client_.link) client_.link->poll();
    }
    const Input input = window_.poll();
    obey(input, controls_, stand());
    follow_path();
    begin_and_end_takes();
    if (controls_.take(Act::Quit)) quit_ = Quit::Wanted;
    if (ended() || restart_ == Restart::Wanted) return std::nullopt;
    return HeadControls{controls_.head, head_input(input), headset_of(controls_, options_.size)};
  }

  void follow_path() {
    if (!client_.network || followed_ == controls_.path) return;
    followed_ = controls_.path;
    client_.network->follow(path_of(controls_.path, path_));
  }

  void begin_and_end_takes() {
    if (controls_.take(Act::RecordHead)) takes_.toggle_head();
    if (controls_.take(Act::RecordFrames)) takes_.toggle_frames();
    if (!controls_.take(Act::RecordSession)) return;
    if (takes_.records_session())
      takes_.end_session();
    else
      restart_ = Restart::Wanted;
  }

  /// A frame was drawn: look into it, keep what is to be kept of it, show it.
  void watch(const FrameView& view) {
    lights_ = view.state.light_set;
    inspection_.look(view, controls_, reference());
    const Composition composition = compose(view);
    keep(view, composition);
    if (!options_.timeline.empty()) timeline_.add(view, client_.link ? &client_.link->inbox() : nullptr);
    const ControlState now = stand();
    const PanelFacts facts = facts_of(now);
    presenter_.show(composition, [&] { draw_panel(controls_, facts); });
    history_.add(view, inspection_.errors(), client_.link ? &*client_.link : nullptr, client_.clock.now());
    tell_title();
  }

  /// Null where none is needed; one that cannot be had is said once and not needed any more.
  Reference* reference() {
    if (!needs_reference(controls_)) return nullptr;
    if (const Expected<void> opened = open_reference(client_); opened) return &*client_.reference;
    controls_.reference = Switch::Off;
    if (controls_.look == Look::Difference) controls_.look = Look::SideBySide;
    if (controls_.overlay == Overlay::Error) controls_.overlay = Overlay::None;
    return nullptr;
  }

  Composition compose(const FrameView& view) {
    constexpr std::array ways{StereoLayout::SideBySide, StereoLayout::CrossEyed, StereoLayout::Mono,
                              StereoLayout::Anaglyph, StereoLayout::SideBySide};
    Composition composition{
        .layout = ways[static_cast<std::size_t>(controls_.look)],
        .pictures = {Picture::LeftEye, Picture::RightEye},
        .aspect = aspect_of(view.shown.views[0]),
        .shared = shared_columns({view.shown.views[0].fov, view.shown.views[1].fov}, controls_.eye_distance_m,
                                 options_.size),
        .right_px = panel_width_px(controls_, window_.framebuffer_size(), window_.content_scale())};
    if (const auto& pictures = inspection_.in_place()) {
      for (const Side side : kSides) presenter_.upload(side, (*pictures)[index_of(side)]);
      composition.pictures = {Picture::LeftUpload, Picture::RightUpload};
    }
    return composition;
  }

  void keep(const FrameView& view, const Composition& composition) {
    if (controls_.take(Act::Screenshot))
      takes_.take_screenshot(inspection_.on_show(), presenter_.read_back(composition));
    takes_.watch(view, takes_.records_session() ? &inspection_.shown() : nullptr,
                 takes_.records_frames() ? &inspection_.on_show() : nullptr);
  }

  PanelFacts facts_of(const ControlState& now) {
    return {.history = history_,
            .scene = client_.scene,
            .stand = now,
            .device = client_.device.name,
            .server = server_state(),
            .note = takes_.note(),
            .recording_head = switch_of(takes_.records_head()),
            .recording_session = switch_of(takes_.records_session()),
            .recording_frames = switch_of(takes_.records_frames()),
            .window = window_.framebuffer_size(),
            .scale = window_.content_scale()};
  }

  [[nodiscard]] std::string server_state() const {
    if (!client_.link)
      return client_.scene.lights.empty()        ? "no lights: no server"
             : options_.mode.mode == Mode::Local ? "shadow maps: no server"
                                                 : "traces here: no server";
    const std::string server =
        std::string(name_of(options_.mode.mode)) + ", server " + to_string(client_.server);
    const std::optional<Time> heard = client_.link->heard_at();
    if (!heard) return server + " does not answer";
    const Duration silence = client_.clock.now() - *heard;
    if (silence > kSilent) return fmt::format("{} silent for {:.0f} s", server, seconds_of(silence));
    return server;
  }

  void tell_title() {
    const Time now = client_.clock.now();
    if (titled_ && now - *titled_ < kTitleEvery) return;
    titled_ = now;
    window_.set_title(fmt::format("{}: {}, {:.0f} frames a second", kTitle, client_.scene.name,
                                  history_.figures().frames_per_s));
  }

  const Options& options_;
  Client& client_;
  Window& window_;
  StopSignal& stop_signal_;
  Presenter presenter_;
  Controls controls_;
  LinkModel path_;  ///< as the command line has it
  std::optional<NetworkSettings> followed_;
  LightSet lights_;  ///< as last shown
  PreviewRuntime runtime_;
  Inspection inspection_;
  History history_;
  Recordings takes_;
  Timeline timeline_;
  std::optional<Time> titled_;
  enum class Restart : std::uint8_t { No, Wanted } restart_ = Restart::No;
  enum class Quit : std::uint8_t { No, Wanted } quit_ = Quit::No;
};

/// Room for both eyes pixel by pixel, small ones enlarged, and the panel.
Extent window_size(const Options& options) {
  const Extent wanted{std::max(options.size.width, kLeastEye_px) * 2 + kFirstPanel_px,
                      std::max(options.size.height, kLeastHeight_px)};
  return {std::min(wanted.width, kMostFirstWindow.width), std::min(wanted.height, kMostFirstWindow.height)};
}

}  // namespace

Expected<void> run_preview(const Options& wish) {
  Options options = wish;
  options.pace = Pace::Real;
  StopSignal stop_signal;
  if (auto done = make_folder(options.out); !done) return done;
  std::optional<HeadRecording> trace;
  if (!options.trace.empty()) {
    Expected<HeadRecording> loaded = load_head_recording(options.trace, {options.trace_scale});
    if (!loaded) return tl::unexpected(loaded.error());
    trace = std::move(*loaded);
  }
  const Expected<LinkModel> path = options.net.empty() ? LinkModel{} : parse_link_model(options.net);
  if (!path) return tl::unexpected(path.error());
  const Expected<std::unique_ptr<Window>> window = open_window(kTitle, window_size(options));
  if (!window) return tl::unexpected(window.error());
  options.device.presentation = (*window)->presentation();
  Expected<std::unique_ptr<Client>> client =
      open_client(options, kWidestEyes_m);  // a viewer may set the eyes apart at any time
  if (!client) return tl::unexpected(client.error());
  if (options.mode.mode == Mode::Full)
    if (auto done = open_own_tracer(**client); !done) return done;

  Expected<void> done, finished;
  {
    Preview preview(options, **client, **window, stop_signal, trace, *path);
    try {
      done = preview.run_all();
    } catch (const std::exception& error) {
      // A lost device, a surface that went: whatever ends the preview, what was taken is kept.
      done = fail(Fault::Unavailable, fmt::format("drawing on {} failed ({}); start again",
                                                  (*client)->device.name, error.what()));
    }
    finished = preview.finish();
  }
  if (done) done = finished;
  return done ? no_validation_messages((*client)->device) : done;
}

}  // namespace farshade
