// rt_server: traces shadows for clients that ask over UDP. Results go to stdout, the log to stderr.
#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>

#include "rt_server/app.h"
#include "rt_server/doctor/doctor.h"
#include "rt_server/keys/keygen.h"

namespace {

using namespace farshade;

void add_serving(CLI::App& app, ServeOptions& options) {
  app.add_option_function<std::string>(
         "--plan", [&options](const std::string& text) { options.plan = parse_plan_options(text); },
         "say what the scene needs and what is left out, and nothing else; --plan=everything serves with "
         "nothing left out, to compare with (clients likewise)")
      ->expected(0, 1)
      ->check(CLI::IsMember({"", "needed", "everything"}));
  app.add_option("--scene", options.scene, "glTF 2.0 file (.gltf or .glb)");
  app.add_option("--listen", options.listen, "address and UDP port; port 0 takes any free one")
      ->capture_default_str();
  app.add_option("--keys", options.ring, "key ring; " + default_ring_path().string() + " unless told");
  app.add_flag("--insecure", options.insecure, "no keys and nothing sealed, on this machine alone");
  app.add_option("--sessions", options.limits.sessions, "most clients at a time")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  app.add_option("--handshakes-per-second", options.limits.handshakes_per_second,
                 "most of clients with a key")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--bytes-per-second", options.limits.bytes_per_second, "most to one client")
      ->check(CLI::Range(25e3, 1e10))
      ->capture_default_str();
  app.add_option("--pixels", options.most_pixels, "most an eye that a client may ask for")
      ->check(CLI::Range(1u, kMaxViewSide_px * kMaxViewSide_px))
      ->capture_default_str();
  app.add_option(
      "--net", options.net,
      "impair what arrives here, as a bad network would: poor, or loss=2%,delay=25ms,jitter=5ms, ...");
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Traces which lights each pixel of a stereo client sees and sends it the masks over UDP.");
  ServeOptions serving;
  KeygenOptions making;
  ServerDoctorOptions examined;
  add_serving(app, serving);
  add_keygen(app, making);
  add_doctor(app, examined);
  app.require_subcommand(0, 1);
  CLI11_PARSE(app, argc, argv);
  if (app.got_subcommand("doctor")) {
    const Findings findings = examine(examined);
    print(findings);
    return any_failed(findings) ? EXIT_FAILURE : EXIT_SUCCESS;
  }
  StopSignal stop;
  spdlog::set_default_logger(spdlog::stderr_logger_mt("rt_server"));
  Expected<void> done;
  if (app.got_subcommand("keygen")) {
    done = keygen(making).map([](const std::string& said) { fmt::print("{}", said); });
  } else if (serving.scene.empty()) {
    return app.exit(CLI::RequiredError("--scene"));
  } else {
    done = serve(serving, stop);
  }
  if (done) return EXIT_SUCCESS;
  std::fprintf(stderr, "rt_server: %s\n", done.error().what.c_str());
  return EXIT_FAILURE;
} catch (const std::exception& error) {
  std::fprintf(stderr, "rt_server: %s\n", error.what());
  return EXIT_FAILURE;
}
