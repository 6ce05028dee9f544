// rt_server: traces shadows for clients that send requests over UDP. Writes results to stdout, the log to
// stderr.
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>

#include "rt_server/app.h"
#include "rt_server/commands/commands.h"
#include "rt_server/log/log_sink.h"
#include "rt_server/log/server_log.h"
#include "stereo/about/about.h"
#include "stereo/base/heap.h"
#include "stereo/base/user_folders.h"
#include "stereo/gpu/loader.h"
#include "stereo/messages/messages.h"
#include "stereo/options/command_line.h"
#include "stereo/options/completion.h"
#include "stereo/options/config_file.h"
#include "stereo/options/lighting_options.h"
#include "stereo/sealing/layout.h"
#include "stereo/video/video.h"

namespace {

using namespace farshade;

constexpr int kBadCommandLine = 2;

constexpr const char* kFooter =
    "Exit status:\n"
    "  0  SIGINT (Ctrl-C) or SIGTERM ended the server, or the subcommand succeeded\n"
    "  1  the server could not start, or the subcommand failed; standard error says why\n"
    "  2  the command line or the configuration file is wrong\n"
    "  130, 143  SIGINT or SIGTERM ended rt_server inspect\n"
    "\n"
    "Signals: SIGUSR1 prints the counters, SIGHUP reads the key ring again.\n"
    "\n"
    "Examples:\n"
    "  rt_server --scene assets/room.glb --listen 0.0.0.0:7447\n\n"
    "  rt_server inspect assets/room.glb";

void add_serving(CLI::App& app, ServeOptions& options) {
  app.add_option_function<std::string>(
         "--plan", [&options](const std::string& text) { options.plan = parse_plan_options(text); },
         "print what the scene needs and what is left out, then exit; --plan=everything serves with "
         "nothing left out, for comparison (start the clients with the same option)")
      ->expected(0, 1)
      ->type_name("needed|everything")
      ->check(one_of({"", "needed", "everything"}));
  app.add_option("--scene", options.scene, "glTF 2.0 file (.gltf or .glb)");
  add_lighting_options(app, options.lighting);
  app.add_option("--listen", options.listen,
                 "address and UDP port; port 0 selects a free port; may be given several times, each address "
                 "once; 0.0.0.0 includes all addresses of IPv4, [::] those of IPv6, too")
      ->allow_extra_args(false)
      ->default_str(options.listen.front());
  app.add_option("--keys", options.ring, "key ring file; default " + default_ring_path().string());
  app.add_flag("--insecure", options.insecure,
               "accept every client on this machine, without keys and without encryption");
  app.add_flag("!--no-scene-fetch", options.scene_fetch,
               "do not send the scene's files to clients that have a key but no --scene");
  app.add_flag(
      "!--no-announce", options.announce,
      "do not tell the local network where this server listens (multicast DNS, through avahi-daemon); "
      "vr_client --server auto then does not find it");
  app.add_option(
      "--ready-file", options.ready_file,
      "for scripts: the server writes a line 'listening ADDRESS' for each --listen to this file when "
      "clients can connect; if no light of the scene casts shadows, it writes 'no-shadows' and exits with "
      "status 0");
  app.add_option("--sessions", options.limits.sessions, "maximum number of connected clients")
      ->check(within(1, 4096))
      ->capture_default_str();
  app.add_option("--handshakes-per-second", options.limits.handshakes_per_second,
                 "maximum number of handshakes per second, over all clients that have a key")
      ->check(within(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--bytes-per-second", options.limits.bytes_per_second,
                 "maximum number of bytes per second that the server sends to one client")
      ->check(within(25e3, 1e10))
      ->capture_default_str();
  app.add_option("--total-bytes-per-second", options.limits.total_bytes_per_second,
                 "maximum number of bytes of answers per second to all clients together; clients of "
                 "different keys share it equally")
      ->check(within(25e3, 1e11))
      ->capture_default_str();
  app.add_option_function<std::size_t>(
         "--memory", [&options](std::size_t mib) { options.limits.memory.limit_bytes = mib << 20; },
         "maximum MiB of memory that clients make the server hold, beyond the scene; what would exceed it, "
         "or a key's share of it, is refused")
      ->check(within(std::size_t{32}, std::size_t{1} << 20))
      ->type_name("MIB")
      ->default_str(std::to_string(kMemory_bytes >> 20));
  app.add_option("--pixels", options.most_pixels,
                 "maximum number of pixels per eye that a client may request")
      ->check(within(1u, kMaxViewSide_px * kMaxViewSide_px))
      ->capture_default_str();
  app.add_option(
      "--net", options.net,
      "simulate a bad network for arriving datagrams: poor, or loss=2%,delay=25ms,jitter=5ms, ...");
}

std::string about_server() {
  return about("rt_server", {fmt::format("client and server {}", kProtocolVersion)},
               {"Vulkan loader " + gpu::loader_version(), has_video() ? video_version() : "no video"});
}

}  // namespace

int main(int argc, char** argv) try {
  check_layout();
  keep_freed_memory();
  CLI::App app(
      "Traces which lights are visible from each pixel of a stereo client, and sends the result as masks "
      "over UDP.",
      "rt_server");
  app.footer(kFooter);
  make_readable(app);
  app.set_version_flag("--version", about_server,
                       "print versions of program, protocol and libraries, and exit");
  ServeOptions serving;
  KeygenOptions key;
  ServerPairOptions paired;
  ServerDoctorOptions doctor;
  InspectOptions inspected;
  add_serving(app, serving);
  add_keygen(app, key);
  add_pair(app, paired);
  add_doctor(app, doctor);
  add_inspect(app, inspected);
  app.require_subcommand(0, 1);
  const ConfigRules config{config_folder() / "rt_server.ini"};
  add_config_option(app, config);
  add_completion_option(app);
  try {
    parse_with_config(app, argc, argv, config);
    if (app.get_subcommands().empty() && serving.scene.empty()) throw CLI::RequiredError("--scene");
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? EXIT_SUCCESS : kBadCommandLine;
  }
  if (app.got_subcommand("doctor")) return report(examine(doctor));
  StopSignal stop(StopSignal::Hangup::IsARequest);
  const ServerLog log;
  Expected<void> done;
  const auto print = [](const std::string& text) { fmt::print("{}", text); };
  if (app.got_subcommand("keygen")) {
    done = keygen(key).map(print);
  } else if (app.got_subcommand("pair")) {
    done = pair_client(paired, stop);
  } else if (app.got_subcommand("inspect")) {
    const StopSignal::EndsAtOnce working(stop, StopSignal::Ending::BySignal);
    done = inspect(inspected).map(print);
  } else {
    std::signal(SIGPIPE, SIG_IGN);  // whoever read the output has ended, and the clients have not
    done = serve(serving, stop);
  }
  if (done) return EXIT_SUCCESS;
  write_now(STDERR_FILENO, "rt_server: " + done.error().what + "\n");
  return EXIT_FAILURE;
} catch (const std::exception& error) {
  std::fprintf(stderr, "rt_server: %s\n", error.what());
  return EXIT_FAILURE;
}
