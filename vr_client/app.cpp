#include "vr_client/app.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <functional>

#include "stereo/base/files.h"
#include "stereo/base/stages.h"
#include "stereo/base/stop_signal.h"
#include "stereo/head/reader.h"
#include "stereo/head/writer.h"
#include "vr_client/client.h"
#include "vr_client/compile_ahead.h"
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/modes/run_frames.h"
#include "vr_client/placed_head.h"
#include "vr_client/record/replay.h"
#include "vr_client/run_outputs.h"
#include "vr_client/runtime/headset.h"
#include "vr_client/runtime/recorded_head_runtime.h"
#include "vr_client/summarize.h"

namespace farshade {
namespace {

HeadPlayback playback_of(const Options& options, const Rigid<Stage, Recorded>& stage_from_recorded = {}) {
  return {.stage_from_recorded = stage_from_recorded,
          .eye_size = options.size,
          .refresh_hz = options.refresh_hz,
          .skip = duration_from_ms(options.skip_s * 1e3),
          .frames = options.frames,
          .pace = options.pace};
}

Expected<HeadRecording> load_head(const Options& options) {
  Expected<HeadRecording> head = load_head_recording(options.trace, options.trace_reading);
  if (!head) return head;
  if (duration_from_ms(options.skip_s * 1e3) > head->end() - head->start())
    return fail(Fault::OutOfRange,
                fmt::format("--skip {:g} skips all of {}, which is {:g} s long", options.skip_s,
                            options.trace.string(), seconds_of(head->end() - head->start())));
  return head;
}

/// Fails if the run was shorter than the user wanted.
Expected<void> check_length(const Options& options, std::uint32_t frames) {
  if (frames >= options.frames.value_or(0)) return {};
  return fail(Fault::OutOfRange,
              fmt::format("--frames {}: {} has only {} frames at {:g} Hz{}", *options.frames,
                          options.trace.string(), frames, options.refresh_hz,
                          options.skip_s > 0 ? fmt::format(" after --skip {:g}", options.skip_s) : ""));
}

/// "183.2 MB on the device at most: vertices 12.3 MB, ...", with the uses that need memory of the device.
std::string in_words(const gpu::BytesByUse& memory) {
  std::string text = megabytes(most_at_once(memory)) + " on the device at most";
  for (std::size_t i = 0; i < gpu::kUses; ++i)
    if (const auto use = static_cast<gpu::Use>(i); memory[use] > 0 && use != gpu::Use::Uploads)
      text += fmt::format("{} {} {}", text.ends_with("most") ? ":" : ",", gpu::to_string(use),
                          megabytes(memory[use]));
  return text;
}

/// A run of less than a second ends sooner if each pipeline is compiled when a frame first needs it. If
/// requests are rare, the server could end the session while a frame compiles. A display does not wait.
bool compiles_ahead(const Options& options, std::uint32_t frames) {
  const bool waits = frames > options.refresh_hz || options.request.every > 1 || options.pace == Pace::Real;
  return waits && draws_scene(options.mode.mode);
}

/// Prints to standard error how many frames of a run are done. On a terminal one line is overwritten with
/// each frame; elsewhere a line follows each tenth of the run.
class Progress {
 public:
  explicit Progress(std::uint32_t frames) : frames_(frames) {}

  /// The silence of the server says nothing about the frames to come.
  void show(std::uint32_t done, const Silence& silence) {
    const std::uint32_t step = on_terminal_ ? 1 : std::max(frames_ / 10, 1u);
    if (done % step != 0 && done != frames_) return;
    const bool counts = silence.frames() < done;
    const double spent_s = seconds_of(watch_.elapsed() - (counts ? silence.time() : Duration::zero()));
    const double left_s = spent_s / (counts ? done - silence.frames() : done) * (frames_ - done);
    fmt::print(stderr, "{}frame {} of {}, about {:.0f} s left   {}", on_terminal_ ? "\r" : "", done, frames_,
               left_s, on_terminal_ ? "" : "\n");
    line_is_open_ = on_terminal_;
    std::fflush(stderr);
  }
  /// Ends the line. A run that skipped its last display times shows no last frame.
  void end() {
    if (std::exchange(line_is_open_, false)) fmt::print(stderr, "\n");
  }

 private:
  std::uint32_t frames_;
  bool on_terminal_ = isatty(STDERR_FILENO) != 0, line_is_open_ = false;
  Stopwatch watch_;
};

/// The frames of a run, until their end or `stop`.
using Frames = std::function<Expected<void>(const FrameWatcher& watch, const std::function<bool()>& stop)>;

/// Shows frames until their end or a stop signal. `first` gets each frame before anything else is drawn.
Expected<void> show(const Frames& shows, std::uint32_t frames, RunOutputs& outputs, StopSignal& stop,
                    const FrameWatcher& first) {
  if (auto done = outputs.begin(); !done) return done;
  Progress progress(frames);
  const auto watch = [&](const FrameView& view) {
    first(view);
    if (const auto news = outputs.watch(view)) {
      progress.end();
      spdlog::warn(*news);
    }
    progress.show(view.shown.frame.value, outputs.silence());
  };
  const Expected<void> done = shows(watch, [&stop] { return stop.has_come(); });
  progress.end();
  if (done && stop.has_come()) fmt::print(stderr, "stopped; writing the reports of the frames so far\n");
  return done;
}

tl::unexpected<Error> interrupted(const Options& options, const RunOutputs& outputs, std::uint32_t frames) {
  return fail(Fault::Interrupted,
              fmt::format("interrupted after {} of {} frames; {} has the reports of these", outputs.frames(),
                          frames, options.out.string()));
}

/// Mismatch if the capture was made with another scene or plan.
Expected<void> check_capture(const CaptureHeader& header, const Options& options, const Client& client) {
  if (client.scene.hash != header.scene_hash)
    return fail(Fault::Mismatch, fmt::format("{} was captured with {}, and {} has other content",
                                             options.replay.string(), header.scene, options.scene.string()));
  if (header.lights != client.plan.draw.mask.lights)
    return fail(Fault::Mismatch,
                fmt::format("{} was captured with masks of {} lights, this plan has {}: "
                            "use the --plan of the captured run",
                            options.replay.string(), header.lights, client.plan.draw.mask.lights));
  return {};
}

}  // namespace

Expected<void> export_head_recording(const Options& options) {
  const Expected<HeadRecording> head = load_head_recording(options.trace, options.trace_reading);
  if (!head) return tl::unexpected(head.error());
  tell_how_read(*head);
  const std::filesystem::path kind = options.export_trace.extension();
  if (kind == ".csv") return write_file_atomically(options.export_trace, euroc_text(*head));
  if (kind == ".tum" || kind == ".txt") return write_file_atomically(options.export_trace, tum_text(*head));
  return fail(Fault::Unsupported,
              fmt::format("unknown format of {}: name the file .csv (EuRoC/ASL) or .tum (TUM)",
                          options.export_trace.string()));
}

Expected<void> print_plan(const Options& options) {
  Headset headset;
  headset.eye_size = options.size;
  headset.fov.fill(field_of_view(1.5, static_cast<double>(options.size.width) / options.size.height));
  std::optional<HeadRecording> recording;
  if (!options.trace.empty()) {
    Expected<HeadRecording> loaded = load_head(options);
    if (!loaded) return tl::unexpected(loaded.error());
    recording = std::move(*loaded);
    headset.eye_distance_m = recording->eye_distance_m;
    headset.fov = recording->fov;
  }
  Expected<PlannedScene> planned = load_planned(options, needs_of(options, headset.eye_distance_m));
  if (!planned) return tl::unexpected(planned.error());
  planned->plan.draw.passes = options.passes.value_or(planned->plan.draw.passes);
  planned->plan.draw.edge_rays = has_edge_rays(options, planned->plan.draw);
  const Scene& scene = planned->scene;
  const SceneLevels levels = levels_for(scene, planned->plan);
  const Rigid<Stage, Eye> camera = viewpoint_of(scene, options.start_pose);
  const StereoView views = views_of({camera.rotation, camera.translation}, headset);
  const auto line = [](const char* what, const std::string& words) {
    fmt::print("  {:<12} {}\n", what, words);
  };
  fmt::print("{}", in_words(planned->plan, scene));
  line("triangles", fmt::format("at most {} of {} at the reference camera, both eyes",
                                gbuffer_triangles(scene, planned->plan.draw, levels, views),
                                gbuffer_triangles(scene, planned->plan.draw, {}, views)));
  if (planned->plan.draw.edge_rays)
    line("edges", fmt::format("rays of the client's own, for as many lights as fit into {} of light buffers",
                              megabytes(kMostEdgeRayBytes)));
  line("memory", in_words(client_memory(scene, planned->plan.draw, renderer_limits(options), levels,
                                        maps_of(options))));
  if (!recording) return {};
  return place_head(options, scene, *recording).map([](const PlacedHead&) {});
}

Expected<void> run_replay(const Options& options, StopSignal& stop) {
  Stages stages(kSteadyClock);
  if (auto done = RunOutputs::prepare(options); !done) return done;
  const Expected<std::uint32_t> frames = count_frames(options.replay);
  if (!frames) return tl::unexpected(frames.error());
  Expected<CaptureReader> reader = CaptureReader::open(options.replay);
  if (!reader) return tl::unexpected(reader.error());
  const CaptureHeader header = reader->header();
  stages.end("capture");
  Expected<std::unique_ptr<Client>> opened = open_client(
      options, {.kind = options.plan.kind, .detail_px = static_cast<float>(header.detail_px)}, stages);
  if (!opened) return tl::unexpected(opened.error());
  Client& client = **opened;
  if (auto fits = check_capture(header, options, client); !fits) return fits;
  const Mode mode = header.origin == MaskOrigin::OwnTracer ? Mode::Full : Mode::Hybrid;
  if (auto done = open_drawing(options, mode, client, header.limits, stages); !done) return done;

  RunOutputs outputs(options, client, stages, report_options(options, *frames, Compare::AtOnce));
  Replay replay(std::move(*reader), report_of(options));
  client.exposure = header.exposure;
  RunContext context = context_of(options, client, replay, replay.settings());
  context.policy = header.policy;
  context.mode = {.mode = mode};
  context.link = replay.link();
  const auto compare = [&](const FrameView& view) { replay.watch(view, client.renderer->read_shown()); };
  const auto replay_frames = [&](const FrameWatcher& watch, const std::function<bool()>& until) {
    return run(context, *make_pipeline(context), watch, until);
  };
  if (auto done = show(replay_frames, *frames, outputs, stop, compare); !done) return done;
  const Expected<ReplayVerdict> verdict = replay.verdict();
  const auto conclude = [&]() -> Expected<void> {
    if (!verdict) return tl::unexpected(verdict.error());
    return summarize(options, client,
                     FinishedReplay{.log = *outputs.log(),
                                    .header = header,
                                    .mode = mode,
                                    .verdict = to_string(*verdict),
                                    .interrupted = stop.has_come()});
  };
  if (auto done = outputs.finish(stop.has_come(), conclude); !done) return done;
  if (auto done = no_validation_messages(client.device); !done) return done;
  if (stop.has_come()) return interrupted(options, outputs, *frames);
  if (!verdict->first && verdict->cut_off) return fail(Fault::Malformed, *verdict->cut_off);
  if (!verdict->first) return {};
  const bool elsewhere = client.device.name != header.device;
  return fail(Fault::Mismatch,
              to_string(*verdict) + (elsewhere ? "; it was captured on " + header.device : std::string()));
}

namespace {

struct OpenedRun {
  std::unique_ptr<Client> client;
  PlacedHead head;
  std::uint32_t frames = 0;  ///< to be shown
  FrameSettings settings;
};

/// Compiles the pipelines of a run, unless its frames do so as they need them.
void compile_for(const Options& options, Client& client, std::uint32_t frames,
                 const FrameSettings& settings) {
  if (compiles_ahead(options, frames))
    compile_ahead(client, settings.reprojection, settings.report, Changes::Never);
}

/// Everything for a run but the server. What does not depend on each other is opened side by side.
Expected<OpenedRun> open_run(const Options& options, Stages& stages) {
  Expected<HeadRecording> recording = load_head(options);
  if (!recording) return tl::unexpected(recording.error());
  stages.end("head");
  Expected<std::unique_ptr<Client>> opened =
      open_client(options, needs_of(options, recording->eye_distance_m), stages);
  if (!opened) return tl::unexpected(opened.error());
  Client& client = **opened;
  const std::uint32_t frames = frame_count(*recording, playback_of(options));
  auto placing = place_meanwhile(options, client.scene, std::move(*recording));
  const FrameSettings settings{
      .request = options.request, .reprojection = options.reprojection, .report = report_of(options)};
  const auto compile = [&] { compile_for(options, client, frames, settings); };
  if (auto done = open_drawing(options, options.mode.mode, client, renderer_limits(options), stages, compile);
      !done)
    return tl::unexpected(done.error());
  Expected<PlacedHead> head = placing.get();
  if (!head) return tl::unexpected(head.error());
  stages.end("head");
  return OpenedRun{std::move(*opened), std::move(*head), frames, settings};
}

/// With the virtual clock, each run shows the same pictures.
void wait_for_edge_rays(const Client& client, StopSignal& stop, Stages& stages) {
  constexpr Duration kPoll = std::chrono::milliseconds(10);
  if (!client.edge_rays) return;
  while (!stop.has_come() && client.edge_rays->data().wait_for(kPoll) != std::future_status::ready) {
  }
  stages.end("light buffers");
}

/// Shows the frames of a run, over losses of its device.
Expected<void> show_run(const Options& options, const OpenedRun& run, Runtime& runtime, RunOutputs& outputs,
                        StopSignal& stop) {
  Client& client = *run.client;
  const FrameDevice device{.context = [&] { return context_of(options, client, runtime, run.settings); },
                           .clear =
                               [&] {
                                 outputs.lose_device();
                                 client.renderer.reset();
                               },
                           .reopen =
                               [&] {
                                 return reopen_device(options, client).map([&] {
                                   compile_for(options, client, run.frames, run.settings);
                                 });
                               }};
  const Frames over_losses = [&](const FrameWatcher& watch, const std::function<bool()>& until) {
    return run_frames(device, watch, until);
  };
  return show(over_losses, run.frames, outputs, stop, [](const FrameView&) {});
}

}  // namespace

Expected<void> run_client(const Options& options, StopSignal& stop) {
  Stages stages(kSteadyClock);
  if (auto done = RunOutputs::prepare(options); !done) return done;
  const Expected<OpenedRun> opened = open_run(options, stages);
  if (!opened) return tl::unexpected(opened.error());
  const PlacedHead& head = opened->head;
  Client& client = *opened->client;
  RecordedHeadRuntime runtime(head.recording, playback_of(options, head.stage_from_recorded));
  RunOutputs outputs(options, client, stages,
                     report_options(options, opened->frames,
                                    options.pace == Pace::Real ? Compare::AfterTheRun : Compare::AtOnce));
  if (options.pace == Pace::Virtual) wait_for_edge_rays(client, stop, stages);
  if (auto done = open_link(options, client, outputs.listener()); !done) return done;
  if (client.link) client.link->give_up_when([&stop] { return stop.has_come(); });
  if (head.exposure) client.exposure = head.exposure;
  if (auto done = outputs.open_capture(options); !done) return done;
  stages.end("server");

  if (options.pace == Pace::Real)
    draw_ahead(context_of(options, client, runtime, opened->settings),
               head.recording.start() + duration_from_ms(options.skip_s * 1e3));
  const Expected<void> shown = show_run(options, *opened, runtime, outputs, stop);
  const bool has_lost_device = client.renderer == nullptr;
  if (!shown && (!has_lost_device || outputs.frames() == 0)) return shown;
  const bool is_cut = !shown || stop.has_come();
  const auto conclude = [&] {
    return summarize(options, client,
                     FinishedRun{.log = *outputs.log(),
                                 .silence = outputs.silence(),
                                 .missed = runtime.skipped(),
                                 .interrupted = is_cut,
                                 .head_test = head.test});
  };
  if (auto done = outputs.finish(is_cut, conclude); shown && !done) return done;
  if (outputs.captures())
    fmt::print(readable_output(options), "captured {} frames, {}, to {}\n", outputs.capture().frames(),
               megabytes(outputs.capture().bytes()), options.record.string());
  if (!shown) return shown;
  if (auto fine = no_validation_messages(client.device); !fine) return fine;
  if (stop.has_come()) return interrupted(options, outputs, opened->frames);
  return check_answered(client, *outputs.log()).and_then([&] {
    return check_length(options, opened->frames);
  });
}

}  // namespace farshade
