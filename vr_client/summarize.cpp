#include "vr_client/summarize.h"

#include <fmt/format.h>

#include "stereo/base/files.h"
#include "vr_client/report/summary.h"

namespace farshade {
namespace {

RunTotals totals_of(const Client& client, Extent eye_size, double refresh_hz, const FrameLog& log) {
  return {.period = duration_from_ms(1e3 / refresh_hz),
          .frames = log.records().size(),
          .start_up_frames = client.link ? log.start_up_frames() : 0,
          .memory_bytes = client.device.ledger->read().peak_total,
          .eye_size = eye_size,
          .cpu_draws = client.device.is_cpu};
}

std::string heading(const RunSetting& setting, const RunTotals& totals, const Client& client) {
  std::string text =
      fmt::format("{} along {}: {} frames of {}x{} an eye at {:g} Hz in mode {}, on {}\n", setting.scene,
                  setting.head, totals.frames, setting.eye_size.width, setting.eye_size.height,
                  setting.refresh_hz, name_of(setting.mode), setting.device);
  if (client.link && setting.pace == Pace::Virtual)
    text += fmt::format("answers are used {:g} ms after their request\n", setting.delay_ms);
  if (totals.start_up_frames > 0)
    text += fmt::format("{} frames were shown before the first answer; the errors exclude them\n",
                        totals.start_up_frames);
  if (totals.silent_frames > 0)
    text += fmt::format("the server was silent for {:.1f} s: {} frames, which no run time includes\n",
                        seconds_of(totals.silent), totals.silent_frames);
  if (client.edge_rays)
    text +=
        fmt::format("edge rays: {}\n", client.edge_rays->is_done() ? in_words(client.edge_rays->data().get())
                                                                   : "the light buffers were not ready");
  return text + fmt::format("memory on the device: {} at peak, {} estimated by the plan\n",
                            megabytes(totals.memory_bytes), megabytes(totals.planned_memory_bytes));
}

/// With what the light buffers take instead of the limit, once that is known.
std::uint64_t planned_memory(const Client& client, const RendererLimits& limits,
                             const ShadowMapSettings* maps = nullptr) {
  gpu::BytesByUse memory = client_memory(client.scene, client.plan.draw, limits, client.levels, maps);
  if (client.edge_rays && client.edge_rays->is_done())
    memory[gpu::Use::EdgeRays] = client.edge_rays->data().get().bytes();
  return most_at_once(memory);
}

/// The verdict, `about` the run, and the rows that matter in the mode.
Expected<void> write_summary(const Options& options, const RunSetting& setting, const RunTotals& totals,
                             const FrameLog& log, const std::string& about) {
  fmt::print(readable_output(options),
             "{}\n{}\n{}\n{} has all figures; vr_client --explain FIGURE defines them\n",
             in_words(verdict_of(log, totals), totals), about, table(log, setting.mode),
             (options.out / "summary.csv").string());
  if (options.json.empty()) return {};
  const std::string json = summary_json(setting, totals, log);
  if (options.json != "-") return write_file_atomically(options.json, json);
  fmt::print("{}", json);
  return {};
}

}  // namespace

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) * 1e-6);
}

const ShadowMapSettings* maps_of(const Options& options) {
  return options.mode.mode == Mode::Local ? &options.mode.shadow_maps : nullptr;
}

std::FILE* readable_output(const Options& options) {
  return options.json == "-" ? stderr : stdout;
}

Expected<void> summarize(const Options& options, const Client& client, const FinishedRun& run) {
  const RunSetting setting{.scene = options.scene.filename().string(),
                           .device = client.device.name,
                           .head = run.head.empty() ? options.trace.filename().string() : run.head,
                           .mode = options.mode.mode,
                           .eye_size = options.size,
                           .refresh_hz = options.refresh_hz,
                           .pace = options.pace,
                           .delay_ms = options.delay_ms,
                           .interrupted = run.interrupted};
  RunTotals totals = totals_of(client, options.size, options.refresh_hz, run.log);
  totals.reference_every = options.reference_every;
  if (const std::vector<double>& rate = options.path_mbit_s; !rate.empty())
    totals.stated_path = {rate.front(), rate.size() > 1 ? std::optional(rate.back()) : std::nullopt};
  totals.missed = run.missed;
  if (run.head_test.tested > 0)
    totals.inside_share =
        static_cast<double>(run.head_test.inside) / static_cast<double>(run.head_test.tested);
  totals.silent = run.silence.time();
  totals.silent_frames = run.silence.frames();
  totals.planned_memory_bytes = planned_memory(client, renderer_limits(options), maps_of(options));
  return write_summary(options, setting, totals, run.log, heading(setting, totals, client));
}

Expected<void> summarize(const Options& options, const Client& client, const FinishedReplay& replay) {
  const CaptureHeader& header = replay.header;
  const RunSetting setting{.scene = header.scene,
                           .device = client.device.name,
                           .head = options.replay.filename().string(),
                           .mode = replay.mode,
                           .eye_size = header.limits.size,
                           .refresh_hz = header.refresh_hz,
                           .pace = header.policy.pace,
                           .delay_ms = ms_of(header.policy.delay),
                           .interrupted = replay.interrupted};
  RunTotals totals = totals_of(client, header.limits.size, header.refresh_hz, replay.log);
  totals.planned_memory_bytes = planned_memory(client, header.limits);
  return write_summary(options, setting, totals, replay.log,
                       fmt::format("{} from {} on {}: {}\n", header.scene, options.replay.string(),
                                   client.device.name, replay.verdict));
}

Expected<void> check_answered(const Client& client, const FrameLog& log) {
  if (!client.link || client.link->receiver().newest_known() != nullptr ||
      log.start_up_frames() < log.records().size())
    return {};
  return fail(
      Fault::Missing,
      fmt::format("no answer came from {} during the whole run, so no frame shows what the server adds. "
                  "Is rt_server running there, and does UDP reach it? vr_client doctor --server {} tells",
                  to_string(client.server), to_string(client.server)));
}

}  // namespace farshade
