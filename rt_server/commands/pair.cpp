#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "rt_server/commands/commands.h"
#include "stereo/net/local_addresses.h"
#include "stereo/options/within.h"
#include "stereo/pair/pairing.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// The addresses to put into a code, the best one first: one of this machine alone is of little use. A code
/// with the usual port does not name it.
std::vector<std::string> addresses_of(const ServerPairOptions& options, std::span<const Peer> locals) {
  std::vector<Peer> peers;
  for (const Peer& local : locals) {
    const std::vector<Peer> all = is_unspecified(local) ? local_addresses(local.port) : std::vector<Peer>{};
    if (all.empty()) peers.push_back(local);
    peers.insert(peers.end(), all.begin(), all.end());
  }
  std::stable_partition(peers.begin(), peers.end(), [](const Peer& peer) { return !is_loopback(peer); });
  std::vector<std::string> found;
  for (const Peer& peer : peers) {
    const std::string whole = to_string(peer);
    std::string text = options.address.empty() ? whole.substr(0, whole.rfind(':')) : options.address;
    if (peer.port != kPairingPort) text += fmt::format(":{}", peer.port);
    if (std::ranges::find(found, text) == found.end()) found.push_back(text);
  }
  return found;
}

void print_code(const PairingCode& code, const std::vector<std::string>& addresses, double minutes) {
  fmt::print("rt_server: waits {:g} minutes for one new client. Enter there:\n\n  vr_client pair {}\n\n",
             minutes, to_string(code));
  if (addresses.size() > 1)
    fmt::print(
        "rt_server: this machine has more addresses; if {} does not answer, put another one in its place: "
        "{}\n",
        addresses.front(), fmt::join(addresses.begin() + 1, addresses.end(), ", "));
  std::fflush(stdout);
}

}  // namespace

void add_pair(CLI::App& program, ServerPairOptions& options) {
  CLI::App* command = program.add_subcommand(
      "pair", "Shows a code with which one new client brings its key to the ring (vr_client pair CODE).");
  command->add_option("--ring", options.ring,
                      "the server's key ring; default " + default_ring_path().string());
  command
      ->add_option("--listen", options.listen,
                   "address and TCP port to wait on; port 0 selects a free port; may be given several times")
      ->allow_extra_args(false)
      ->default_str(options.listen.front())
      ->configurable(false);  // in a file, listen is the server's: another port
  command->add_option(
      "--address", options.address,
      "the host to show in the code, if clients know this machine by another name or address");
  command->add_option("--minutes", options.minutes, "life of the code")
      ->check(within(0.01, 60))
      ->capture_default_str();
}

Expected<void> pair_client(const ServerPairOptions& options, StopSignal& stop) {
  const fs::path ring = options.ring.empty() ? default_ring_path() : fs::path(options.ring);
  if (const auto keys = load_key_ring(ring); !keys && keys.error().fault != Fault::Missing)
    return tl::unexpected(keys.error());
  Expected<TcpServer> server = listen_tcp(options.listen, kPairingPort);
  if (!server) return tl::unexpected(server.error());
  const std::vector<std::string> addresses = addresses_of(options, server->addresses);
  const PairingCode code = new_pairing_code(addresses.front());
  print_code(code, addresses, options.minutes);
  const PairingLimits limits{.life = duration_from_ms(options.minutes * 60e3)};
  const Expected<PairedClient> paired = wait_for_pairing(
      std::move(server->listener), code, [&](const SharedKey& key) { return append_to_ring(ring, key); },
      limits, [&] { return stop.has_come(); });
  if (!paired) return tl::unexpected(paired.error());
  fmt::print(
      "rt_server: paired with {}: its key '{}' is in {}\n"
      "rt_server: a running server with this ring takes the key within 3 seconds\n",
      to_string(paired->client), paired->key.name, ring.string());
  return {};
}

}  // namespace farshade
