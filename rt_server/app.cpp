#include "rt_server/app.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <filesystem>

#include "rt_server/answers/answers.h"
#include "rt_server/core/serve.h"
#include "stereo/base/files.h"
#include "stereo/net/explain.h"
#include "stereo/net/impaired_port.h"
#include "stereo/net/udp.h"
#include "stereo/scene/gltf.h"

namespace farshade {
namespace {

Expected<std::vector<SharedKey>> who_may_come(const ServeOptions& options) {
  if (options.insecure) return std::vector{insecure_key()};
  const std::filesystem::path path =
      options.ring.empty() ? default_ring_path() : std::filesystem::path(options.ring);
  Expected<std::vector<SharedKey>> ring = load_key_ring(path);
  if (!ring && ring.error().fault == Fault::Missing)
    return fail(Fault::Missing,
                "no keys at " + path.string() +
                    ": make one with rt_server keygen NAME, or name another ring with --keys");
  if (ring && ring->empty())
    return fail(Fault::Missing, path.string() + " holds no key: make one with rt_server keygen NAME");
  return ring;
}

Expected<std::unique_ptr<DatagramPort>> open_port(const ServeOptions& options, const Clock& clock) {
  Expected<std::unique_ptr<DatagramPort>> port = listen_udp(options.listen);
  if (!port) return port;
  if (options.insecure && !is_loopback((*port)->local()))
    return fail(Fault::Unsupported,
                "--insecure lets in whoever comes, so it listens on this machine alone: " + options.listen +
                    " is not 127.0.0.1 or [::1]");
  if (options.net.empty()) return port;
  const Expected<LinkModel> model = parse_link_model(options.net);
  if (!model) return tl::unexpected(model.error());
  return impaired(std::move(*port), *model, clock);
}

/// "12.3 MB (vertices 1.2, ...)", of 10^6 bytes.
std::string in_words(const TracerMemory& memory) {
  const auto megabytes = [](std::size_t bytes) { return static_cast<double>(bytes) * 1e-6; };
  return fmt::format(
      "{:.2f} MB (vertices {:.2f}, triangles {:.2f}, facets {:.2f}, hierarchy {:.2f} (while it was built "
      "{:.2f}), maps of lights {:.2f})",
      megabytes(memory.total()), megabytes(memory.vertices), megabytes(memory.triangles),
      megabytes(memory.facets), megabytes(memory.hierarchy), megabytes(memory.hierarchy_peak),
      megabytes(memory.maps));
}

Expected<void> write_ready_file(const ServeOptions& options, const std::string& line) {
  if (options.ready_file.empty()) return {};
  return write_file_atomically(options.ready_file, line + "\n");
}

/// A script that waits for the ready file must not read the one of an earlier server.
Expected<void> remove_old_ready_file(const ServeOptions& options) {
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
  fmt::print("rt_server: {}\n", reason);
  return write_ready_file(options, std::string(kReadyNoShadows));
}

void say_counters(const ServerCore& core) {
  const ServerCounters counters = core.counters();
  fmt::print("{}\n{}\n", counters_line(counters), rays_line(counters.traced));
  std::fflush(stdout);
}

}  // namespace

Expected<void> serve(const ServeOptions& options, StopSignal& stop) {
  if (const Expected<void> removed = remove_old_ready_file(options); !removed) return removed;
  Expected<Scene> loaded = load_scene(options.scene);
  if (!loaded) return tl::unexpected(loaded.error());
  const auto [scene, plan] = plan_scene(std::move(*loaded), {.kind = options.plan.kind});
  if (options.plan.only_told) {
    fmt::print("{}  {:<12} the tracer holds {}\n", in_words(plan, scene), "memory",
               in_words(foreseen_memory(scene, plan.trace)));
    return {};
  }
  if (!plan.server) return end_without_shadows(options);
  const SteadyClock clock;
  const Expected<std::vector<SharedKey>> ring = who_may_come(options);
  if (!ring) return tl::unexpected(ring.error());
  const Expected<std::unique_ptr<DatagramPort>> port = open_port(options, clock);
  if (!port) return tl::unexpected(port.error());
  Expected<Tracer> tracer = Tracer::create(scene, plan.trace);
  if (!tracer) return tl::unexpected(tracer.error());

  const auto trace = [&](const FrameRequest& request, ShadowFrame& frame) {
    return tracer->trace(request, frame);
  };
  Answers answers({.scene = scene, .plan = plan, .tracer = *tracer});
  const Welcome served{scene.hash, plan.trace.mask.lights, options.most_pixels, answers.offered()};
  ServerCore core(served, *ring, trace, **port, clock, options.limits,
                  plan.one_value_tiles ? SameAllOver::OneValue : SameAllOver::EachPixel,
                  [&](const Job& job, FramePacker& packer) { return answers.answer(job, packer); });
  fmt::print("rt_server: serving {}, {} triangles, {} lights, scene {}\n", scene.name, scene.triangle_count,
             plan.trace.mask.lights, short_form(scene.hash));
  fmt::print("rt_server: the tracer holds {}\n", in_words(tracer->memory()));
  if (options.insecure)
    fmt::print("rt_server: insecure: no keys, nothing is sealed\n");
  else
    fmt::print("rt_server: {} {} in the ring\n", ring->size(), ring->size() == 1 ? "key" : "keys");
  fmt::print("rt_server: listening on {}\n", to_string((*port)->local()));
  std::fflush(stdout);
  {
    const Serving serving(core);
    const std::string line = fmt::format("{} {}", kReadyListening, to_string((*port)->local()));
    if (const Expected<void> written = write_ready_file(options, line); !written) return written;
    stop.wait([&] { say_counters(core); });
  }
  say_counters(core);
  return {};
}

}  // namespace farshade
