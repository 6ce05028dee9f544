#include "vr_client/app.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "stereo/base/files.h"
#include "stereo/base/stop_signal.h"
#include "stereo/head/reader.h"
#include "stereo/head/writer.h"
#include "vr_client/client.h"
#include "vr_client/record/capture_writer.h"
#include "vr_client/record/replay.h"
#include "vr_client/report/run_report.h"
#include "vr_client/report/timeline.h"
#include "vr_client/runtime/headset.h"
#include "vr_client/runtime/recorded_head_runtime.h"

namespace farshade {
namespace {

HeadPlayback playback_of(const Options& options, const Scene& scene, const HeadRecording& trace) {
  HeadPlayback playback{.stage_from_recorded = {},
                        .eye_size = options.size,
                        .refresh_hz = options.refresh_hz,
                        .skip = duration_from_ms(options.skip_s * 1e3),
                        .frames = options.frames,
                        .pace = options.pace};
  if (options.place == Place::Camera && scene.camera)
    playback.stage_from_recorded = place(trace, *scene.camera);
  return playback;
}

Expected<HeadRecording> load_trace(const Options& options) {
  Expected<HeadRecording> trace = load_head_recording(options.trace, {options.trace_scale});
  if (trace && duration_from_ms(options.skip_s * 1e3) > trace->end() - trace->start())
    return fail(Fault::OutOfRange,
                fmt::format("--skip {:g} leaves nothing of {}, which is {:g} s long", options.skip_s,
                            options.trace.string(), seconds_of(trace->end() - trace->start())));
  if (trace && trace->rows_left_out > 0)
    spdlog::warn("{}: {} rows are left out, their stamps repeat others or run backward",
                 options.trace.string(), trace->rows_left_out);
  return trace;
}

/// One line that overwrites itself on a terminal, a line every tenth part elsewhere.
class Progress {
 public:
  explicit Progress(std::uint32_t frames) : frames_(frames) {}

  void show(std::uint32_t done) {
    const bool terminal = isatty(STDERR_FILENO) != 0;
    const std::uint32_t step = terminal ? 1 : std::max(frames_ / 10, 1u);
    if (done % step != 0 && done != frames_) return;
    const double left = seconds_of(watch_.elapsed()) / done * (frames_ - done);
    fmt::print(stderr, "{}frame {} of {}, about {:.0f} s left{}", terminal ? "\r" : "", done, frames_, left,
               terminal && done != frames_ ? "   " : "   \n");
    std::fflush(stderr);
  }

 private:
  std::uint32_t frames_;
  Stopwatch watch_;
};

Expected<void> write_timeline(const Options& options, const Timeline& timeline) {
  return options.timeline.empty() ? Expected<void>{} : timeline.write(options.timeline);
}

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) * 1e-6);
}

/// "183.2 MB on the device at most: vertices 12.3 MB, ...", of those uses that take any.
std::string in_words(const gpu::BytesByUse& memory) {
  std::string text = megabytes(most_at_once(memory)) + " on the device at most";
  for (std::size_t i = 0; i < gpu::kUses; ++i)
    if (const auto use = static_cast<gpu::Use>(i); memory[use] > 0)
      text += fmt::format("{} {} {}", text.ends_with("most") ? ":" : ",", gpu::to_string(use),
                          megabytes(memory[use]));
  return text;
}

/// What the plan foresaw, and what it came to.
std::string memory_line(const Client& client, const RendererLimits& limits) {
  return fmt::format("memory on the device: {} at most, {} foreseen by the plan\n",
                     megabytes(client.renderer->counters().memory.peak_total),
                     megabytes(most_at_once(client_memory(client.scene, client.plan.draw, limits))));
}

std::string heading(const Options& options, const Client& client, const RecordedHeadRuntime& runtime,
                    const FrameLog& log) {
  std::string text =
      fmt::format("{} along {}: {} frames of {}x{} an eye at {:g} Hz, on {}\n",
                  options.scene.filename().string(), options.trace.filename().string(), log.records().size(),
                  options.size.width, options.size.height, options.refresh_hz, client.device.name);
  if (client.link && options.pace == Pace::Virtual)
    text += fmt::format("mode {}: answers come {:g} ms after they were asked for\n",
                        name_of(options.mode.mode), options.delay_ms);
  else
    text += fmt::format("mode {}\n", name_of(options.mode.mode));
  if (client.link && log.start_up_frames() > 0)
    text += fmt::format("{} frames were shown before the first answer; errors below are of the others\n",
                        log.start_up_frames());
  if (runtime.skipped() > 0) text += fmt::format("{} display times were missed\n", runtime.skipped());
  return text;
}

bool measures(const Options& options) {
  return options.reference_every > 0 || !options.dump.empty();
}

ShadingPass::Report report_for(const RunReport& recorder) {
  return recorder.measures_any() ? ShadingPass::Report::On : ShadingPass::Report::Off;
}

/// Runs the session and writes what is asked for of it. `first` sees each frame before anything else is
/// drawn.
Expected<void> show(const Options& options, const RunContext& session, std::uint32_t frames,
                    RunReport& recorder, StopSignal& stop_signal, const FrameWatcher& first) {
  // Written once before there is anything in it, to learn early that it cannot be.
  Timeline timeline;
  if (auto done = write_timeline(options, timeline); !done) return done;
  // What a replay takes in came at times of the recording's clock.
  const AnswerInbox* const inbox = session.link && options.replay.empty() ? &session.link->inbox() : nullptr;
  Progress progress(frames);
  const auto watch = [&](const FrameView& view) {
    first(view);
    recorder.watch(view);
    if (!options.timeline.empty()) timeline.add(view, inbox);
    progress.show(view.shown.frame.value);
  };
  const auto stop = [&] { return stop_signal.has_come() || recorder.failed().has_value(); };
  if (auto done = run(session, watch, stop); !done) return done;
  if (stop_signal.has_come()) fmt::print(stderr, "\nstopped; writing what was shown so far\n");

  for (const std::uint32_t dump : options.dump)
    if (dump == 0 || dump > recorder.log().records().size())
      spdlog::warn("frame {} was not shown and is not dumped", dump);
  if (auto done = recorder.finish(); !done) return done;
  return write_timeline(options, timeline);
}

}  // namespace

Expected<void> export_trace(const Options& options) {
  const Expected<HeadRecording> trace = load_head_recording(options.trace, {options.trace_scale});
  if (!trace) return tl::unexpected(trace.error());
  const std::filesystem::path kind = options.export_trace.extension();
  if (kind == ".csv") return write_euroc(options.export_trace, *trace);
  if (kind == ".tum" || kind == ".txt") return write_tum(options.export_trace, *trace);
  return fail(Fault::Unsupported,
              fmt::format("cannot tell the format of {}: name it .csv (EuRoC/ASL) or .tum (TUM)",
                          options.export_trace.string()));
}

Expected<void> tell_plan(const Options& options) {
  double eye_distance_m = Headset{}.eye_distance_m;
  if (!options.trace.empty()) {
    const Expected<HeadRecording> trace = load_head_recording(options.trace, {options.trace_scale});
    if (!trace) return tl::unexpected(trace.error());
    eye_distance_m = trace->eye_distance_m;
  }
  const Expected<PlannedScene> planned = load_planned(options, needs_of(options, eye_distance_m));
  if (!planned) return tl::unexpected(planned.error());
  fmt::print("{}  {:<12} {}\n", in_words(planned->plan, planned->scene), "memory",
             in_words(client_memory(planned->scene, planned->plan.draw, renderer_limits(options))));
  return {};
}

Expected<void> run_replay(const Options& options) {
  StopSignal stop_signal;
  if (auto done = make_folder(options.out); !done) return done;
  const Expected<std::uint32_t> frames = count_frames(options.replay);
  if (!frames) return tl::unexpected(frames.error());
  Expected<CaptureReader> reader = CaptureReader::open(options.replay);
  if (!reader) return tl::unexpected(reader.error());
  const CaptureHeader header = reader->header();
  Expected<std::unique_ptr<Client>> opened = open_client(options, {.kind = options.plan.kind}, header.limits);
  if (!opened) return tl::unexpected(opened.error());
  Client& client = **opened;
  if (client.scene.hash != header.scene_hash)
    return fail(Fault::Mismatch, fmt::format("{} was recorded of {}, of which {} has not the same content",
                                             options.replay.string(), header.scene, options.scene.string()));
  if (header.lights != client.plan.draw.mask.lights)
    return fail(Fault::Mismatch,
                fmt::format("{} was recorded with masks of {} lights, this plan has {}: "
                            "give the recording's --plan",
                            options.replay.string(), header.lights, client.plan.draw.mask.lights));
  if (header.origin == MaskOrigin::OwnTracer)
    if (auto done = open_own_tracer(client); !done) return done;
  if (measures(options))
    if (auto done = open_reference(client); !done) return done;

  Reference* const reference = client.reference ? &*client.reference : nullptr;
  RunReport recorder({options.out, *frames, options.reference_every, options.pictures, options.dump},
                     *client.renderer, reference);
  Replay replay(std::move(*reader), report_for(recorder));
  const RunContext session{
      .scene = client.scene,
      .runtime = replay,
      .renderer = *client.renderer,
      .mode = {.mode = header.origin == MaskOrigin::OwnTracer ? Mode::Full : Mode::Hybrid},
      .link = replay.link(),
      .own_tracer = client.own_tracer ? &*client.own_tracer : nullptr,
      .steering = replay.steering(),
      .policy = header.policy};
  const auto compare = [&](const FrameView& view) { replay.watch(view, client.renderer->read_shown()); };
  if (auto done = show(options, session, *frames, recorder, stop_signal, compare); !done) return done;
  const Expected<ReplayVerdict> verdict = replay.verdict();
  if (!verdict) return tl::unexpected(verdict.error());
  fmt::print("{} from {} on {}: {}\n{}", header.scene, options.replay.string(), client.device.name,
             to_string(*verdict), table(recorder.log().summary()));
  fmt::print("wrote {}\n", options.out.string());
  if (auto done = no_validation_messages(client.device); !done) return done;
  if (!verdict->first) return {};
  const bool elsewhere = client.device.name != header.device;
  return fail(Fault::Mismatch,
              to_string(*verdict) + (elsewhere ? "; it was recorded on " + header.device : std::string()));
}

Expected<void> run_client(const Options& options) {
  StopSignal stop_signal;
  if (auto done = make_folder(options.out); !done) return done;
  const Expected<HeadRecording> trace = load_trace(options);
  if (!trace) return tl::unexpected(trace.error());
  Expected<std::unique_ptr<Client>> opened = open_client(options, trace->eye_distance_m);
  if (!opened) return tl::unexpected(opened.error());
  Client& client = **opened;
  if (options.mode.mode == Mode::Full)
    if (auto done = open_own_tracer(client); !done) return done;
  if (measures(options))
    if (auto done = open_reference(client); !done) return done;
  const bool taped = !options.record.empty();
  CaptureWriter tape(client.clock);
  if (auto done = open_link(options, client, taped ? tape.listener() : LinkListener{}); !done) return done;
  const MaskPolicy policy{.pace = options.pace,
                          .delay = duration_from_ms(options.delay_ms),
                          .round_trip = client.round_trip,
                          .mask_wait = duration_from_ms(options.mask_wait_ms)};
  if (taped)
    if (auto done = tape.open(options.record, header_of(options, client, policy)); !done) return done;

  RecordedHeadRuntime runtime(*trace, playback_of(options, client.scene, *trace));
  Reference* const reference = client.reference ? &*client.reference : nullptr;
  const std::uint32_t frames = runtime.frame_count();
  RunReport recorder({options.out, frames, options.reference_every, options.pictures, options.dump},
                     *client.renderer, reference);
  const FrameSettings steering{
      .wish = options.request, .carry_over = options.carry_over, .report = report_for(recorder)};
  const RunContext session{.scene = client.scene,
                           .runtime = runtime,
                           .renderer = *client.renderer,
                           .mode = options.mode,
                           .link = client.link ? &*client.link : nullptr,
                           .own_tracer = client.own_tracer ? &*client.own_tracer : nullptr,
                           .steering = steering,
                           .policy = policy};
  const auto record = [&](const FrameView& view) {
    if (taped && !tape.failed()) tape.watch(view, client.renderer->read_shown());
  };
  if (auto done = show(options, session, frames, recorder, stop_signal, record); !done) return done;
  fmt::print("{}{}{}", heading(options, client, runtime, recorder.log()),
             memory_line(client, renderer_limits(options)), table(recorder.log().summary()));
  fmt::print("wrote {}\n", options.out.string());
  if (tape.failed()) return tl::unexpected(*tape.failed());
  if (taped)
    fmt::print("recorded {} frames, {:.1f} MB, to {}\n", tape.frames(),
               static_cast<double>(tape.bytes()) * 1e-6, options.record.string());
  return no_validation_messages(client.device);
}

}  // namespace farshade
