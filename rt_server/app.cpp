#include "rt_server/app.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "rt_server/answers/answers.h"
#include "rt_server/fetch/scene_sender.h"
#include "rt_server/keys/keys_in_use.h"
#include "rt_server/log/server_log.h"
#include "rt_server/work/server_core.h"
#include "stereo/announce/announcer.h"
#include "stereo/base/files.h"
#include "stereo/base/stages.h"
#include "stereo/exposure/chosen_exposure.h"
#include "stereo/gltf/load_lit_scene.h"
#include "stereo/net/explain.h"
#include "stereo/net/impaired_port.h"
#include "stereo/net/udp.h"

namespace farshade {
namespace {

/// None for the insecure key.
std::optional<std::filesystem::path> key_ring_of(const ServeOptions& options) {
  if (options.insecure) return std::nullopt;
  return options.ring.empty() ? default_ring_path() : std::filesystem::path(options.ring);
}

Expected<UdpServer> open_port(const ServeOptions& options, const Clock& clock) {
  Expected<UdpServer> server = listen_udp(options.listen);
  if (!server) return server;
  const auto reachable = std::ranges::find_if_not(server->addresses, is_loopback);
  if (options.insecure && reachable != server->addresses.end())
    return fail(Fault::Unsupported,
                "--insecure accepts every client, so the server must listen on this machine alone: " +
                    to_string(*reachable) + " is not 127.0.0.1 or [::1]");
  if (options.net.empty()) return server;
  const Expected<LinkModel> model = parse_link_model(options.net);
  if (!model) return tl::unexpected(model.error());
  server->port = impaired(std::move(server->port), *model, clock);
  return server;
}

/// For example "12.3 MB (vertices 1.2, ...)". 1 MB is 10^6 bytes.
std::string in_words(const TracerMemory& memory) {
  const auto megabytes = [](std::size_t bytes) { return static_cast<double>(bytes) * 1e-6; };
  return fmt::format(
      "{:.2f} MB (vertices {:.2f}, triangles {:.2f}, facets {:.2f}, hierarchy {:.2f} (while building it "
      "{:.2f}))",
      megabytes(memory.total()), megabytes(memory.vertices), megabytes(memory.triangles),
      megabytes(memory.facets), megabytes(memory.hierarchy), megabytes(memory.hierarchy_peak));
}

/// Each line of `text` ends with a newline.
Expected<void> write_ready_file(const ServeOptions& options, const std::string& text) {
  if (options.ready_file.empty()) return {};
  return write_file_atomically(options.ready_file, text);
}

/// Prints where the server listens, and writes the ready file.
Expected<void> tell_addresses(const ServeOptions& options, std::span<const Peer> addresses) {
  std::string listening;
  for (const Peer& address : addresses) {
    say(fmt::format("rt_server: listening on {}", to_string(address)));
    listening += fmt::format("{} {}\n", kReadyListening, to_string(address));
  }
  return write_ready_file(options, listening);
}

/// A script that waits for the ready file must not read the one of an earlier server, or of one that has
/// ended.
Expected<void> remove_ready_file(const ServeOptions& options) {
  std::error_code failed;
  if (!options.ready_file.empty()) std::filesystem::remove(options.ready_file, failed);
  if (failed) return fail(Fault::Unreadable, options.ready_file + " cannot be removed: " + failed.message());
  return {};
}

/// Clients shade such a scene without a server. A script learns that from the ready file.
Expected<void> end_without_shadows(const ServeOptions& options) {
  const std::string reason = options.scene +
                             " has no light that casts shadows: there is nothing to serve, clients shade it "
                             "without a server (--plan prints details)";
  if (options.ready_file.empty()) return fail(Fault::Unsupported, reason);
  say("rt_server: " + reason);
  return write_ready_file(options, std::string(kReadyNoShadows) + "\n");
}

void print_what_is_served(const Scene& scene, const ScenePlan& plan, const Tracer& tracer) {
  say(fmt::format("rt_server: serving {}, {} triangles, {} lights, scene {}", scene.name,
                  scene.triangle_count, plan.trace.mask.lights, short_form(scene.hash)));
  say(fmt::format("rt_server: the tracer holds {}", in_words(tracer.memory())));
}

void print_keys(const ServeOptions& options, std::size_t keys) {
  if (options.insecure)
    say("rt_server: insecure: any client on this machine may connect, nothing is encrypted");
  else
    say(fmt::format("rt_server: the key ring contains {} {}", keys, keys == 1 ? "key" : "keys"));
}

/// Masks are sent if a request was answered in this time.
constexpr Duration kMasksAreRecent = std::chrono::seconds(1);

/// Starts to send the scene's files on the TCP ports of the same addresses, without those where that is not
/// possible; empty if it is possible nowhere.
std::unique_ptr<SceneSender> offer_scene(const ServeOptions& options, std::span<const Peer> addresses,
                                         SceneToSend what, const ServerCore& core) {
  if (!options.scene_fetch) return nullptr;
  std::optional<TcpListener> all;
  for (const Peer& address : addresses) {
    Expected<TcpListener> listener = TcpListener::listen(address);
    if (!listener)
      spdlog::warn("clients of {} cannot fetch the scene: {}", to_string(address), listener.error().what);
    else if (all)
      all->join(*std::move(listener));
    else
      all.emplace(*std::move(listener));
  }
  if (!all) return nullptr;
  return std::make_unique<SceneSender>(
      *std::move(all), std::move(what), [&core] { return core.answered_within(kMasksAreRecent); },
      SenderLimits{.bytes_per_second = options.limits.bytes_per_second});
}

/// Tells the local network where the server listens, unless no other machine can reach it.
std::unique_ptr<Announcer> announce(const ServeOptions& options, std::vector<Peer> addresses) {
  std::erase_if(addresses, is_loopback);
  if (!options.announce || addresses.empty()) return nullptr;
  return std::make_unique<Announcer>(std::move(addresses),
                                     [](const std::string& note) { spdlog::info(note); });
}

void print_counters(const ServerCore& core, const SceneSender* sender) {
  const ServerCounters counters = core.counters();
  say(counters_line(counters));
  if (counters.traced.primary_rays > 0) say(rays_line(counters.traced));
  if (sender != nullptr && sender->counters() != SenderCounters{}) say(counters_line(sender->counters()));
}

/// Most answers are drawn within this time.
constexpr Duration kDrawn = std::chrono::seconds(3);

/// Ends the process, because nothing interrupts a graphics device.
[[noreturn]] void end_while_drawing(const ServeOptions& options, ServerCore& core,
                                    const SceneSender* sender) {
  core.say_goodbye();
  print_counters(core, sender);
  static_cast<void>(remove_ready_file(options));
  flush_log();
  std::_Exit(EXIT_SUCCESS);
}

Expected<void> print_plan(const Scene& scene, const ScenePlan& plan) {
  fmt::print("{}  {:<12} the tracer holds {}\n", in_words(plan, scene), "memory",
             in_words(estimated_memory(scene, plan.trace)));
  return {};
}

/// Chooses the exposure and tells it, unless the user's is part of the scene.
Welcome welcome_of(const ServeOptions& options, const Scene& scene, const ScenePlan& plan) {
  Welcome welcome{
      .scene_hash = scene.hash, .light_count = plan.trace.mask.lights, .most_pixels = options.most_pixels};
  if (options.lighting.exposure) return welcome;
  welcome.exposure = chosen_exposure(scene);
  if (const std::string words = in_words(welcome.exposure, scene.name); !words.empty())
    say("rt_server: " + words);
  return welcome;
}

}  // namespace

Expected<void> serve(const ServeOptions& options, StopSignal& stop) {
  const SteadyClock clock;
  Stages stages(clock);
  std::optional<StopSignal::EndsAtOnce> starting(std::in_place, stop, StopSignal::Ending::Success);
  if (Expected<void> removed = remove_ready_file(options); !removed) return removed;
  Expected<LitScene> loaded =
      load_lit_scene(options.scene, options.lighting, options.scene_fetch ? ListFiles::Yes : ListFiles::No);
  if (!loaded) return tl::unexpected(loaded.error());
  for (const std::string& note : loaded->notes) say("rt_server: " + note);
  const auto [scene, plan] =
      plan_scene(std::move(loaded->scene), {.kind = options.plan.kind, .cube_mask = false});
  if (options.plan.prints_only) return print_plan(scene, plan);
  if (!plan.server) return end_without_shadows(options);
  stages.end("scene");
  Expected<LoadedKeys> loaded_keys = load_keys(key_ring_of(options));
  if (!loaded_keys) return tl::unexpected(loaded_keys.error());
  const std::vector<SharedKey> ring = valid_on(today_by_utc(), loaded_keys->ring);
  const Expected<UdpServer> server = open_port(options, clock);
  if (!server) return tl::unexpected(server.error());
  const Welcome served = welcome_of(options, scene, plan);
  stages.end("exposure");
  Expected<Tracer> tracer = Tracer::create(scene, plan.trace);
  if (!tracer) return tl::unexpected(tracer.error());
  stages.end("tracer");

  ServerCore core(served, ring,
                  make_answers({.scene = scene,
                                .plan = plan,
                                .tracer = *tracer,
                                .exposure = served.exposure,
                                .memory = options.limits.memory}),
                  *server->port, clock, options.limits);
  print_what_is_served(scene, plan, *tracer);
  print_keys(options, loaded_keys->ring.size());
  const auto sender = offer_scene(options, server->addresses,
                                  {options.scene, scene.files, options.lighting, served, ring}, core);
  KeysInUse keys(*std::move(loaded_keys), core, sender.get());
  stages.end("answers");
  say(fmt::format("rt_server: ready after {}", stages.in_words()));
  starting.reset();  // from here on, the end has something to clean up
  // The port is open: what clients send from here on waits in its sockets.
  if (Expected<void> told = tell_addresses(options, server->addresses); !told) return told;
  {
    Serving serving(core);
    const std::unique_ptr<Announcer> announcer = announce(options, server->addresses);
    stop.wait([&] { print_counters(core, sender.get()); }, [&] { keys.reload(); },
              [&] { keys.look_again(); });
    if (!serving.end(kDrawn)) end_while_drawing(options, core, sender.get());
  }
  core.say_goodbye();
  print_counters(core, sender.get());
  return remove_ready_file(options);
}

}  // namespace farshade
