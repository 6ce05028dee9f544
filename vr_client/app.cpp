#include "vr_client/app.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cmath>

#include "stereo/base/files.h"
#include "stereo/base/stop_signal.h"
#include "stereo/net/impaired_port.h"
#include "stereo/net/udp.h"
#include "stereo/scene/gltf.h"
#include "stereo/trace/reader.h"
#include "stereo/trace/writer.h"
#include "vr_client/link/shadow_link.h"
#include "vr_client/recorder.h"
#include "vr_client/trace_runtime.h"

namespace farshade {
namespace {

/// How long a server may take to answer hello before the client goes on without it.
constexpr Duration kMeetPatience = std::chrono::seconds(3);

/// Makes the output folder and shows that it can be written, before any work is done.
Expected<void> prepare_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return fail(Fault::Unreadable, fmt::format("cannot make {}: {}", folder.string(), error.message()));
  const std::filesystem::path probe = folder / ".probe";
  if (auto done = write_file_atomically(probe, std::string_view("")); !done) return done;
  std::filesystem::remove(probe, error);
  return {};
}

TracePlayback playback_of(const Options& options, const Scene& scene, const HeadTrace& trace) {
  TracePlayback playback{.stage_from_recorded = {},
                         .eye_size = options.size,
                         .refresh_hz = options.refresh_hz,
                         .skip = duration_from_ms(options.skip_s * 1e3),
                         .frames = options.frames,
                         .pace = options.pace};
  if (options.place == Place::Camera && scene.camera)
    playback.stage_from_recorded = place(trace, *scene.camera);
  return playback;
}

/// In real time, masks that come later than this find their depth gone.
constexpr double kLongestRoundTrip_ms = 250;

/// Frames that may be needed after they were asked for: while masks are on their way, and as older masks.
std::uint32_t frames_in_flight(const Options& options) {
  const double late_ms = options.pace == Pace::Real ? kLongestRoundTrip_ms : options.delay_ms;
  return static_cast<std::uint32_t>(std::ceil(late_ms * 1e-3 * options.refresh_hz)) +
         static_cast<std::uint32_t>(ShadingPass::kMaxMasks) * options.request.every + 4;
}

RendererLimits renderer_limits(const Options& options) {
  const bool wider = options.mode == Mode::Hybrid && options.request.guard_band == GuardBandUse::Measured;
  return {.size = options.size,
          .traced_size = wider ? largest_traced(options.size) : options.size,
          .depth_frames = frames_in_flight(options)};
}

/// What the session stands on; built top to bottom, torn down in reverse.
struct Client {
  Scene scene;
  HeadTrace trace;
  gpu::Device device;
  std::unique_ptr<Renderer> renderer;
  std::unique_ptr<TraceRuntime> runtime;
  std::optional<Reference> reference;
  SteadyClock clock;
  std::optional<UdpClient> udp;
  std::optional<ShadowLink> link;
  Duration round_trip{};  ///< of the first exchange with the server
};

Expected<SharedKey> key_for(const Options& options, const Peer& server) {
  if (options.insecure) {
    if (is_loopback(server)) return insecure_key();
    return fail(Fault::Unsupported, fmt::format("--insecure talks to this machine alone, not to {}: leave it "
                                                "away, and use a key",
                                                options.server));
  }
  const std::filesystem::path path = options.key.empty() ? default_key_path() : options.key;
  Expected<SharedKey> key = load_key(path);
  if (!key && key.error().fault == Fault::Missing)
    return fail(
        Fault::Missing,
        fmt::format("no key at {}: make one on the server with rt_server keygen NAME and copy it here, "
                    "or name it with --key",
                    path.string()));
  return key;
}

Expected<void> open_link(const Options& options, Client& client) {
  const std::size_t lights = client.scene.lights.size();
  if (options.mode != Mode::Hybrid) return {};
  if (lights == 0) {
    spdlog::info("no light casts shadows: no server is needed");
    return {};
  }
  Expected<UdpClient> udp = connect_udp(options.server);
  if (!udp) return tl::unexpected(udp.error());
  const Expected<SharedKey> key = key_for(options, udp->server);
  if (!key) return tl::unexpected(key.error());
  if (!options.net.empty()) {
    const Expected<LinkModel> model = parse_link_model(options.net);
    if (!model) return tl::unexpected(model.error());
    udp->port = impaired(std::move(udp->port), *model, client.clock);
  }
  client.udp = std::move(*udp);
  client.link.emplace(*client.udp->port, client.clock,
                      LinkTarget{client.udp->server, *key, client.scene.hash, narrow<std::uint32_t>(lights)},
                      frames_in_flight(options));
  const Stopwatch meeting;
  const Expected<void> met = client.link->meet(kMeetPatience);
  client.round_trip = meeting.elapsed() / 2;  // a handshake takes two
  if (met && options.size.pixels() > client.link->inbox().most_pixels())
    return fail(
        Fault::OutOfRange,
        fmt::format("the server traces at most {} pixels an eye (rt_server --pixels), --size asks for {}",
                    client.link->inbox().most_pixels(), options.size.pixels()));
  if (!met) {
    if (met.error().fault == Fault::Mismatch) return met;
    spdlog::warn("{}; going on without shadows from it, and trying again", met.error().what);
  }
  return {};
}

Expected<std::unique_ptr<Client>> open_client(const Options& options) {
  auto client = std::make_unique<Client>();
  Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  client->scene = std::move(*scene);
  if (client->scene.instances.size() > kMaxInstances)
    return fail(Fault::Unsupported,
                fmt::format("{} has {} instances; at most {} can be drawn", options.scene.string(),
                            client->scene.instances.size(), kMaxInstances));
  Expected<HeadTrace> trace = load_head_trace(options.trace, {options.trace_scale});
  if (!trace) return tl::unexpected(trace.error());
  client->trace = std::move(*trace);
  if (duration_from_ms(options.skip_s * 1e3) > client->trace.end() - client->trace.start())
    return fail(Fault::OutOfRange,
                fmt::format("--skip {:g} leaves nothing of {}, which is {:g} s long", options.skip_s,
                            options.trace.string(), seconds_of(client->trace.end() - client->trace.start())));
  Expected<gpu::Device> device = gpu::open_device(options.device);
  if (!device) return tl::unexpected(device.error());
  client->device = std::move(*device);
  spdlog::info("drawing on {}: {}", client->device.name, client->device.why);

  client->renderer = std::make_unique<Renderer>(client->device, client->scene, renderer_limits(options));
  client->runtime =
      std::make_unique<TraceRuntime>(client->trace, playback_of(options, client->scene, client->trace));
  if (options.mode == Mode::Full || options.reference_every > 0 || !options.dump.empty()) {
    Expected<Tracer> tracer = Tracer::create(client->scene);
    if (!tracer) return tl::unexpected(tracer.error());
    client->reference.emplace(std::move(*tracer));
  }
  if (auto opened = open_link(options, *client); !opened) return tl::unexpected(opened.error());
  return client;
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

std::string heading(const Options& options, const Client& client, const FrameLog& log) {
  std::string text =
      fmt::format("{} along {}: {} frames of {}x{} an eye at {:g} Hz, on {}\n",
                  options.scene.filename().string(), options.trace.filename().string(), log.records().size(),
                  options.size.width, options.size.height, options.refresh_hz, client.device.name);
  if (client.link && options.pace == Pace::Virtual)
    text += fmt::format("masks come {:g} ms after they were asked for\n", options.delay_ms);
  if (client.link && log.start_up_frames() > 0)
    text += fmt::format("{} frames were shown before the first mask; errors below are of the others\n",
                        log.start_up_frames());
  if (client.runtime->skipped() > 0)
    text += fmt::format("{} display times were missed\n", client.runtime->skipped());
  return text;
}

Expected<void> no_validation_messages(const gpu::Device& device) {
  if (!device.validation_log) return {};
  const std::vector<std::string> messages = device.validation_log->messages();
  if (messages.empty()) return {};
  return fail(Fault::Malformed,
              fmt::format("{} Vulkan validation messages, the first: {}", messages.size(), messages.front()));
}

}  // namespace

Expected<void> export_trace(const Options& options) {
  const Expected<HeadTrace> trace = load_head_trace(options.trace, {options.trace_scale});
  if (!trace) return tl::unexpected(trace.error());
  const std::filesystem::path kind = options.export_trace.extension();
  if (kind == ".csv") return write_euroc(options.export_trace, *trace);
  if (kind == ".tum" || kind == ".txt") return write_tum(options.export_trace, *trace);
  return fail(Fault::Unsupported,
              fmt::format("cannot tell the format of {}: name it .csv (EuRoC/ASL) or .tum (TUM)",
                          options.export_trace.string()));
}

Expected<void> run_client(const Options& options) {
  StopSignal stop_signal;
  if (auto done = prepare_folder(options.out); !done) return done;
  Expected<std::unique_ptr<Client>> opened = open_client(options);
  if (!opened) return tl::unexpected(opened.error());
  Client& client = **opened;

  Reference* const reference = client.reference ? &*client.reference : nullptr;
  const std::uint32_t frames = client.runtime->frame_count();
  Recorder recorder({options.out, frames, options.reference_every, options.pictures, options.dump},
                    *client.renderer, reference);
  Progress progress(frames);
  const Steering steering{
      .wish = options.request,
      .carry_over = options.carry_over,
      .report = recorder.measures_any() ? ShadingPass::Report::On : ShadingPass::Report::Off};
  const Session session{.scene = client.scene,
                        .runtime = *client.runtime,
                        .renderer = *client.renderer,
                        .link = client.link ? &*client.link : nullptr,
                        .own_tracer = options.mode == Mode::Full ? reference : nullptr,
                        .steering = steering,
                        .policy = {.pace = options.pace,
                                   .delay = duration_from_ms(options.delay_ms),
                                   .round_trip = client.round_trip,
                                   .mask_wait = duration_from_ms(options.mask_wait_ms)}};
  const auto watch = [&](const FrameView& view) {
    recorder.watch(view);
    progress.show(view.shown.frame.value);
  };
  const auto stop = [&] { return stop_signal.has_come() || recorder.failed().has_value(); };
  if (auto done = run(session, watch, stop); !done) return done;
  if (stop_signal.has_come()) fmt::print(stderr, "\nstopped; writing what was shown so far\n");

  for (const std::uint32_t dump : options.dump)
    if (dump == 0 || dump > recorder.log().records().size())
      spdlog::warn("frame {} was not shown and is not dumped", dump);
  if (auto done = recorder.finish(); !done) return done;
  fmt::print("{}{}", heading(options, client, recorder.log()), table(recorder.log().summary()));
  fmt::print("wrote {}\n", options.out.string());
  return no_validation_messages(client.device);
}

}  // namespace farshade
