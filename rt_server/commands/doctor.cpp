#include "rt_server/commands/commands.h"

#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <set>

#include "stereo/announce/announcer.h"
#include "stereo/gltf/load_lit_scene.h"
#include "stereo/net/udp.h"
#include "stereo/options/lighting_options.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/sealing/key_file.h"

namespace farshade {
namespace {

Finding check_served_scene(const ServerDoctorOptions& options) {
  Expected<LitScene> lit = load_lit_scene(options.scene, options.lighting);
  Finding finding = check_scene(lit);
  if (lit && !plan_scene(std::move(lit->scene)).plan.server) {
    finding.severity = Severity::Fail;
    finding.found += ": no light casts shadows";
    finding.cure = "add a light with --light or --sun, or run clients without a server";
  }
  return finding;
}

/// Whether clients find the server by --server auto.
Finding check_announcement() {
  if (const Expected<void> works = can_announce(); !works)
    return {Severity::Warn, "announcement", works.error().what + ": clients need the address of this server",
            "give clients the address, or install avahi-daemon (sudo apt install avahi-daemon)"};
  return {Severity::Ok, "announcement",
          "avahi-daemon runs: clients on this network find the server with --server auto"};
}

/// The ports, and the firewall before them. Reading firewall rules takes root, so that check only gives
/// advice.
Findings check_ports(const std::vector<std::string>& addresses) {
  const Expected<UdpServer> server = listen_udp(addresses);
  if (!server)
    return {failed("port", server.error(),
                   "--listen on a free port of an address of this machine, such as 127.0.0.1:7447 or "
                   "0.0.0.0:7447; ss -ulpn lists the programs that use a port")};
  Findings findings;
  std::set<std::uint16_t> reachable;  // ports
  for (const Peer& local : server->addresses) {
    findings.push_back({Severity::Ok, "port", to_string(local) + " is free"});
    if (!is_loopback(local)) reachable.insert(local.port);
  }
  const Peer& first = server->addresses.front();
  if (reachable.empty())
    findings.push_back(
        {Severity::Ok, "firewall",
         fmt::format("{} is reachable from this machine only; for other machines use --listen 0.0.0.0:{}",
                     to_string(first), first.port)});
  for (const std::uint16_t port : reachable)
    findings.push_back(
        {Severity::Warn, "firewall", "not checked: a firewall may drop the clients' datagrams",
         fmt::format("open the port, for example sudo ufw allow {0}/udp or sudo firewall-cmd "
                     "--add-port={0}/udp (and the same for tcp, if clients fetch the scene), and test with "
                     "vr_client doctor --server HOST:{0} on a client's "
                     "machine",
                     port)});
  if (!reachable.empty()) findings.push_back(check_announcement());
  return findings;
}

}  // namespace

void add_doctor(CLI::App& program, ServerDoctorOptions& options) {
  CLI::App* command = program.add_subcommand(
      "doctor",
      "Checks what the server needs on this machine and names cures. Exit status 1 if a check FAILs.");
  command->add_option("--keys", options.ring,
                      "key ring to check (default: " + default_ring_path().string() + ")");
  command->add_option("--listen", options.listen, "address and UDP port to check; may be given several times")
      ->allow_extra_args(false)
      ->default_str(options.listen.front());
  command->add_option("--scene", options.scene, "scene to load");
  add_lighting_options(*command, options.lighting);
}

Findings examine(const ServerDoctorOptions& options) {
  Findings findings{check_build()};
  if (!options.scene.empty()) findings.push_back(check_served_scene(options));
  const std::filesystem::path ring =
      options.ring.empty() ? default_ring_path() : std::filesystem::path(options.ring);
  findings.push_back(check_key_file(ring, KeyFile::Ring));
  for (Finding& finding : check_ports(options.listen)) findings.push_back(std::move(finding));
  findings.push_back(check_socket_buffers());
  return findings;
}

}  // namespace farshade
