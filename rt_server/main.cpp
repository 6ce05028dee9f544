// rt_server: traces shadows for clients that ask over UDP. Results go to stdout, the log to stderr.
#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>

#include "rt_server/serve.h"
#include "stereo/base/check.h"
#include "stereo/base/stop_signal.h"
#include "stereo/net/explain.h"
#include "stereo/net/udp.h"
#include "stereo/scene/gltf.h"

namespace {

using namespace farshade;

struct Options {
  std::string scene;
  std::string listen = "127.0.0.1:7447";
};

Expected<void> run(const Options& options, StopSignal& stop) {
  const Expected<std::unique_ptr<DatagramPort>> port = listen_udp(options.listen);
  if (!port) return tl::unexpected(port.error());
  const Expected<Scene> scene = load_scene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  const LightSet lights = state_at(*scene, Time{}).light_set;
  if (lights.lights.empty())
    return fail(Fault::Unsupported,
                options.scene + " has no lights: nothing to serve, clients shade it alone");
  Expected<Tracer> tracer = Tracer::create(*scene);
  if (!tracer) return tl::unexpected(tracer.error());

  const SteadyClock clock;
  const Welcome served{scene->hash, narrow<std::uint32_t>(lights.lights.size()), lights.revision};
  const auto trace = [&](const TraceRequest& request, ShadowFrame& frame) {
    return tracer->trace(request, frame);
  };
  ServerCore core(served, trace, **port, clock);
  fmt::print("rt_server: serving {}, {} triangles, {} lights, scene {}\n", scene->name, scene->triangle_count,
             lights.lights.size(), short_form(scene->hash));
  fmt::print("rt_server: listening on {}\n", to_string((*port)->local()));
  std::fflush(stdout);
  {
    const Serving serving(core);
    stop.wait();
  }
  fmt::print("{}\n", closing_line(core.counters()));
  return {};
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Traces which lights each pixel of a stereo client sees and sends it the masks over UDP.");
  Options options;
  app.add_option("--scene", options.scene, "glTF 2.0 file (.gltf or .glb)")->required();
  app.add_option("--listen", options.listen, "address and UDP port; port 0 takes any free one")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  StopSignal stop;
  spdlog::set_default_logger(spdlog::stderr_logger_mt("rt_server"));
  const Expected<void> done = run(options, stop);
  if (done) return EXIT_SUCCESS;
  std::fprintf(stderr, "rt_server: %s\n", done.error().what.c_str());
  return EXIT_FAILURE;
} catch (const std::exception& error) {
  std::fprintf(stderr, "rt_server: %s\n", error.what());
  return EXIT_FAILURE;
}
