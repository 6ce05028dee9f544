#include "vr_client/client.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <future>
#include <utility>

#include "stereo/announce/find_server.h"
#include "stereo/base/user_folders.h"
#include "stereo/exposure/chosen_exposure.h"
#include "stereo/gltf/load_lit_scene.h"
#include "stereo/gpu/pipeline_cache.h"
#include "stereo/lod/level_cache.h"
#include "stereo/messages/timing.h"
#include "stereo/net/explain.h"
#include "stereo/net/udp.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/raster/max_instances.h"
#include "stereo/scene/lighting.h"
#include "stereo/video/video.h"

namespace farshade {
namespace {

/// If the server does not answer a hello within this time, the client starts without it.
constexpr Duration kConnectTimeout = std::chrono::seconds(3);

/// In real time, the depth of a requested view is kept for this long; in a preview, kWorstPreviewPath_ms
/// longer. Masks that arrive later cannot be used.
constexpr double kLongestRoundTrip_ms = 250;

}  // namespace

RendererLimits renderer_limits(const Options& options) {
  const Mode mode = options.mode.mode;
  // The viewer of a preview may switch the guard band on at any time.
  const bool wider =
      has_guard_band(mode) && (options.preview || options.request.guard_band == GuardBandUse::Measured);
  return {.size = options.size,
          .traced_size = wider ? largest_traced(options.size) : options.size,
          .depth_frames = reprojects_masks(mode) ? requests_in_flight(options) : 1};
}

Expected<std::string> server_address(const std::string& server) {
  if (!is_search(server)) return server;
  const Expected<FoundServer> found = find_server(server);
  if (!found) return tl::unexpected(found.error());
  spdlog::info("found the server {}", in_words(*found));
  return address_text(found->address);
}

Expected<SharedKey> key_for(const Options& options, const Peer& server) {
  if (options.insecure) {
    if (is_loopback(server)) return insecure_key();
    return fail(Fault::Unsupported, fmt::format("--insecure works on this machine only, not with {}: omit it "
                                                "and use a key",
                                                to_string(server)));
  }
  const std::filesystem::path path = options.key.empty() ? default_key_path() : options.key;
  Expected<SharedKey> key = load_key(path);
  if (!key && key.error().fault == Fault::Missing)
    return fail(Fault::Missing, fmt::format("no key file at {}: bring one to the server with vr_client pair "
                                            "(rt_server pair shows the code there), "
                                            "or name the file with --key",
                                            path.string()));
  return key;
}

namespace {

Expected<LinkModel> network_of(const Options& options) {
  if (options.net.empty()) return LinkModel{};
  return parse_link_model(options.net);
}

/// Does this build support the mode, and are the shadow maps of mode local small enough?
Expected<void> check_mode(const ModeSettings& settings, const Scene& scene) {
  const bool streams = settings.mode == Mode::Remote || settings.mode == Mode::Delta;
  if (streams && !has_video())
    return fail(Fault::Unavailable,
                fmt::format("mode {} needs video: {}", name_of(settings.mode), video_version()));
  if (settings.mode != Mode::Local) return {};
  return shadow_map_bytes(scene, settings.shadow_maps).map([](std::uint64_t) {});
}

}  // namespace

std::uint32_t requests_in_flight(const Options& options) {
  double late_ms = options.pace == Pace::Real ? kLongestRoundTrip_ms : options.delay_ms;
  if (options.preview) late_ms += kWorstPreviewPath_ms;
  const double late_frames = std::ceil(late_ms * 1e-3 * options.refresh_hz);
  // The viewer of a preview may change the rate.
  const std::uint32_t every = options.preview ? 1 : std::max(options.request.every, 1u);
  return static_cast<std::uint32_t>(std::ceil(late_frames / every)) + static_cast<std::uint32_t>(kMaxMasks) +
         4;
}

/// Only mode hybrid requests a cube mask, and not beside blocks of masks; only a reprojection can look it up.
/// The viewer of a preview may switch the reprojection on.
bool needs_cube_mask(const Options& options) {
  return options.mode.mode == Mode::Hybrid && options.mode.mask_code == MaskCode::Range &&
         (options.preview || options.reprojection.lookup == Lookup::Reproject);
}

SessionNeeds needs_of(const Options& options, double eye_distance_m) {
  return {.kind = options.plan.kind,
          .two_views = eye_distance_m != 0,
          .reprojects = reprojects_masks(options.mode.mode),
          .cube_mask = needs_cube_mask(options),
          .detail_px = options.detail_px.value_or(default_detail_px(options.mode.mode))};
}

Expected<PlannedScene> load_planned(const Options& options, const SessionNeeds& needs) {
  Expected<LitScene> lit = load_lit_scene(options.scene, options.lighting);
  if (!lit) return tl::unexpected(lit.error());
  for (const std::string& note : lit->notes) spdlog::info(note);
  if (options.served && lit->scene.hash != *options.served)
    return fail(
        Fault::Mismatch,
        fmt::format("the scene from {} has the hash {} here and {} there: build client and server from "
                    "the same source, or restart the server if a file of its scene has changed",
                    options.server, short_form(lit->scene.hash), short_form(*options.served)));
  return plan_scene(std::move(lit->scene), needs);
}

SceneLevels levels_for(const Scene& scene, const ScenePlan& plan) {
  if (plan.draw.detail_px <= 0) return {};
  const Stopwatch watch;
  CachedLevels cached = cached_levels(scene, cache_folder());
  if (!cached.trouble.empty()) spdlog::warn("levels of detail: {}", cached.trouble);
  spdlog::info("levels of detail {} in {:.0f} ms", cached.from_file ? "read from the cache" : "made",
               ms_of(watch.elapsed()));
  return std::move(cached.levels);
}

namespace {

/// The device before it, if there is one, ends here; what the validation layers said about it is kept.
void take_device(Client& client, gpu::Device device) {
  const gpu::Device before = std::exchange(client.device, std::move(device));
  if (before.validation_log && client.device.validation_log)
    for (const std::string& message : before.validation_log->messages())
      client.device.validation_log->add(message);
  client.is_first_start = !gpu::load_pipelines(client.device, cache_folder());
  spdlog::info("drawing on {}: {}", client.device.name, client.device.why);
}

}  // namespace

Expected<std::unique_ptr<Client>> open_client(const Options& options, const SessionNeeds& needs,
                                              Stages& stages) {
  auto client = std::make_unique<Client>();
  auto opening = std::async(std::launch::async, [&] { return gpu::open_device(options.device); });
  Expected<PlannedScene> planned = load_planned(options, needs);
  if (!planned) return tl::unexpected(planned.error());
  client->scene = std::move(planned->scene);
  client->plan = std::move(planned->plan);
  if (client->scene.instances.size() > kMaxInstances)
    return fail(Fault::Unsupported,
                fmt::format("{} has {} instances; at most {} can be drawn", options.scene.string(),
                            client->scene.instances.size(), kMaxInstances));
  if (auto fit = check_mode(options.mode, client->scene); !fit) return tl::unexpected(fit.error());
  stages.end("scene");
  Expected<gpu::Device> device = opening.get();
  if (!device) return tl::unexpected(device.error());
  take_device(*client, std::move(*device));
  stages.end("device");
  return client;
}

namespace {

/// Where the processor draws, it has no time left for another frame, and the picture would come later.
std::uint32_t frames_in_flight(const Options& options, const gpu::Device& device) {
  if (options.frames_in_flight) return *options.frames_in_flight;
  return options.pace == Pace::Real && !device.is_cpu ? 2 : 1;
}

/// With the passes and frames in flight that suit the device.
void make_renderer_of(const Options& options, Client& client) {
  client.plan.draw.edge_rays = has_edge_rays(options, client.plan.draw);
  client.plan.draw.passes = client.plan.draw.edge_rays
                                ? ShadingPasses::Sorted
                                : options.passes.value_or(suited_passes(client.device));
  client.limits.frames = frames_in_flight(options, client.device);
  if (client.plan.draw.edge_rays && !client.edge_rays)
    client.edge_rays =
        std::make_unique<EdgeRayWork>(client.scene, client.plan.draw, client.device.max_texels);
  client.renderer = make_renderer(client.device, client.scene, client.plan.draw, client.limits, client.levels,
                                  client.edge_rays ? client.edge_rays->data() : FutureEdgeRayData());
}

}  // namespace

void open_renderer(const Options& options, Client& client, const RendererLimits& limits) {
  client.levels = levels_for(client.scene, client.plan);
  client.limits = limits;
  make_renderer_of(options, client);
}

bool has_edge_rays(const Options& options, const DrawPlan& plan) {
  const bool looks_up = options.preview || options.reprojection.lookup == Lookup::Reproject;
  return options.reprojection.edges == Edges::Exact && looks_up && reprojects_masks(plan);
}

Expected<void> reopen_device(const Options& options, Client& client) {
  Expected<gpu::Device> device = gpu::open_device(options.device);
  if (!device) return tl::unexpected(device.error());
  take_device(client, std::move(*device));
  make_renderer_of(options, client);
  return {};
}

Expected<void> reopen_renderer(const Options& options, Client& client, double eye_distance_m) {
  if (auto fit = check_mode(options.mode, client.scene); !fit) return fit;
  client.renderer.reset();  // first, so that the memory of one renderer is enough
  client.plan.draw = plan_for(client.scene, needs_of(options, eye_distance_m)).draw;
  open_renderer(options, client, renderer_limits(options));
  return {};
}

Expected<void> open_reference(Client& client) {
  if (client.reference) return {};
  return Tracer::create_reference(client.scene, client.plan.trace).map([&](Tracer&& tracer) {
    client.reference = std::make_unique<Reference>(std::move(tracer));
  });
}

Expected<void> open_tracers(const Options& options, Mode mode, Client& client) {
  if (mode == Mode::Full && !client.own_tracer) {
    Expected<Tracer> tracer = Tracer::create(client.scene, client.plan.trace);
    if (!tracer) return tl::unexpected(tracer.error());
    client.own_tracer = std::make_unique<Reference>(std::move(*tracer));
  }
  const bool measures = !options.preview && (options.reference_every > 0 || !options.dump.empty());
  return measures ? open_reference(client) : Expected<void>{};
}

Expected<void> open_drawing(const Options& options, Mode mode, Client& client, const RendererLimits& limits,
                            Stages& stages, const std::function<void()>& compile) {
  auto tracing = std::async(std::launch::async, [&] { return open_tracers(options, mode, client); });
  open_renderer(options, client, limits);
  stages.end("renderer");
  compile();
  stages.end("pipelines");
  Expected<void> done = tracing.get();
  stages.end("tracers");
  return done;
}

namespace {

/// Makes the link to `client.server` and greets it. Missing if it does not answer.
Expected<void> greet(const Options& options, Client& client, LinkListener listener) {
  const Expected<SharedKey> key = key_for(options, client.server);
  if (!key) return tl::unexpected(key.error());
  client.link =
      std::make_unique<NetworkLink>(*client.network, client.clock,
                                    LinkTarget{client.server, *key, client.scene.hash, client.plan.draw.mask,
                                               answers_for(options.mode.mode)},
                                    requests_in_flight(options));
  client.link->tell(std::move(listener));
  const Stopwatch connecting;
  Expected<void> connected = client.link->connect(kConnectTimeout);
  if (connected) client.round_trip = connecting.elapsed() / 2;  // a handshake takes two round trips
  if (connected && options.size.pixels() > client.link->receiver().most_pixels())
    return fail(
        Fault::OutOfRange,
        fmt::format("the server traces at most {} pixels per eye (rt_server --pixels), but {}x{} are {}: "
                    "choose a smaller {}",
                    client.link->receiver().most_pixels(), options.size.width, options.size.height,
                    options.size.pixels(), options.device.maker ? "--xr-scale" : "--size"));
  return connected;
}

/// The network of a preview may be impaired later, by its sliders.
void open_network(const Options& options, const LinkModel& model, std::unique_ptr<DatagramPort> port,
                  Client& client) {
  if (options.net.empty() && !options.preview) {
    client.network = std::move(port);
    return;
  }
  auto simulator = impaired(std::move(port), model, client.clock,
                            [&clock = client.clock](Time steady) { return clock.at(steady); });
  client.simulator = simulator.get();
  client.network = std::move(simulator);
}

/// Lets a client start whose link is not connected, unless the server has refused it.
Expected<void> allow_silence(const Client& client, Expected<void> connected) {
  const bool keeps_trying =
      !connected && client.link && !client.link->refused() &&
      (connected.error().fault == Fault::Missing || connected.error().fault == Fault::Unavailable);
  if (!keeps_trying) return connected;
  spdlog::warn("{}; the client starts without its shadows and keeps trying", connected.error().what);
  return {};
}

}  // namespace

Expected<void> connect(const Options& options, Client& client, LinkListener listener) {
  client.link.reset();
  return allow_silence(client, greet(options, client, std::move(listener)));
}

Expected<void> open_link(const Options& options, Client& client, const LinkListener& listener) {
  if (answers_for(options.mode.mode) == 0) return {};
  if (!client.plan.server) {
    spdlog::info("no light casts shadows, so no server is needed");
    return {};
  }
  const Expected<LinkModel> model = network_of(options);
  if (!model) return tl::unexpected(model.error());
  const auto servers = server_address(options.server).and_then(resolve_udp);
  if (!servers) return tl::unexpected(servers.error());
  Expected<void> connected;
  for (const Peer& server : *servers) {
    Expected<UdpClient> udp = connect_udp(server);
    if (!udp) {
      connected = tl::unexpected(udp.error());
      continue;
    }
    client.link.reset();
    client.server = server;
    open_network(options, *model, std::move(udp->port), client);
    connected = greet(options, client, listener);
    const bool is_silent = !connected && client.link && connected.error().fault == Fault::Missing;
    if (!is_silent || server == servers->back()) break;
    spdlog::info("{} does not answer; trying the next address of {}", to_string(server), options.server);
  }
  return allow_silence(client, std::move(connected));
}

void SessionKeeper::keep(Client& client) {
  constexpr Duration kInterval = std::chrono::seconds(1);
  static_assert(3 * kInterval < kSessionTimeout);
  if (!client.link) return;
  client.link->poll();
  const Time now = kSteadyClock.now();
  if (kept_alive_ && now - *kept_alive_ < kInterval) return;
  kept_alive_ = now;
  client.link->keep_alive();
}

Exposure settle_exposure(const Options& options, Client& client) {
  const auto told = client.link ? client.link->receiver().exposure() : std::nullopt;
  if (told && told != client.exposure)
    if (const std::string words = in_words(*told, client.scene.name); !words.empty())
      spdlog::info("the server says: {}", words);
  if (told) client.exposure = told;
  if (!client.exposure)
    client.exposure = options.lighting.exposure ? Exposure{} : chosen_exposure(client.scene);
  return *client.exposure;
}

namespace {

MaskPolicy policy_of(const Options& options, const Client& client) {
  return {.pace = options.pace, .delay = duration_from_ms(options.delay_ms), .round_trip = client.round_trip};
}

/// A capture has the views of a frame once.
Locate locate_of(const Options& options) {
  const bool is_live = options.pace == Pace::Real && options.record.empty() && options.replay.empty();
  return is_live ? Locate::ForDrawing : Locate::Once;
}

}  // namespace

RunContext context_of(const Options& options, Client& client, Runtime& runtime,
                      const FrameSettings& settings) {
  return {.scene = client.scene,
          .runtime = runtime,
          .renderer = *client.renderer,
          .mode = options.mode,
          .link = client.link.get(),
          .own_tracer = client.own_tracer.get(),
          .settings = settings,
          .exposure = settle_exposure(options, client),
          .policy = policy_of(options, client),
          .locate = locate_of(options),
          .clock = client.clock};
}

CaptureHeader header_of(const Options& options, const Client& client) {
  const bool traces = options.mode.mode == Mode::Full && client.plan.server;
  return {.scene = options.scene.filename().string(),
          .scene_hash = client.scene.hash,
          .lights = client.plan.draw.mask.lights,
          .origin = client.link ? MaskOrigin::Server
                    : traces    ? MaskOrigin::OwnTracer
                                : MaskOrigin::Nobody,
          .limits = renderer_limits(options),
          .detail_px = double{client.plan.draw.detail_px},
          .requests = requests_in_flight(options),
          .refresh_hz = options.refresh_hz,
          .exposure = client.exposure.value_or(Exposure{}),
          .policy = policy_of(options, client),
          .device = client.device.name};
}

Expected<void> no_validation_messages(const gpu::Device& device) {
  if (!device.validation_log) return {};
  const std::vector<std::string> messages = device.validation_log->messages();
  if (messages.empty()) return {};
  return fail(Fault::Malformed,
              fmt::format("{} Vulkan validation messages, the first: {}", messages.size(), messages.front()));
}

}  // namespace farshade
