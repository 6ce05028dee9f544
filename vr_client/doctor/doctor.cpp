#include "vr_client/doctor/doctor.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>

#include "stereo/announce/find_server.h"
#include "stereo/gltf/load_lit_scene.h"
#include "stereo/gpu/device.h"
#include "stereo/messages/timing.h"
#include "stereo/net/explain.h"
#include "stereo/net/udp.h"
#include "stereo/options/lighting_options.h"
#include "stereo/sealing/handshake.h"
#include "stereo/sealing/key_file.h"
#include "vr_client/fetch/fetch_scene.h"

namespace farshade {
namespace {

constexpr const char* kDriverCure =
    "install a driver: sudo apt install libvulkan1 mesa-vulkan-drivers (Mesa draws on the CPU if there is no "
    "GPU), or the driver of the GPU's maker; VK_DRIVER_FILES and VK_ICD_FILENAMES, if set, must name "
    "existing "
    "files";

Finding check_drawing() {
  const Expected<gpu::Device> device = gpu::open_device({});
  if (!device) return failed("drawing", device.error(), kDriverCure);
  return {Severity::Ok, "drawing", fmt::format("{} opens: {}", device->name, device->why)};
}

Finding check_window_system() {
  for (const char* name : {"WAYLAND_DISPLAY", "DISPLAY"})
    if (const char* value = std::getenv(name); value != nullptr && *value != '\0')
      return {Severity::Ok, "window system", fmt::format("{}={}", name, value)};
  return {Severity::Warn, "window system",
          "neither WAYLAND_DISPLAY nor DISPLAY is set: --preview cannot work",
          "run the client in a desktop session, or set DISPLAY"};
}

/// Whom to contact, with which key, about which scene.
struct Contact {
  std::string server;
  SharedKey key;
  std::optional<ContentHash> scene;
};

/// What the server answered. An open refusal is not authenticated; an accepted handshake replaces it.
struct HelloAnswer {
  std::optional<OpenRefusal> open_refusal;
  std::optional<ServerMessage> message;  ///< Welcome or Refusal
};

/// Ends the session that a server has made for a client that will not use it.
void leave(DatagramPort& port, const Peer& server, const SessionKeys& keys) {
  Sealer sealer(keys.session, keys.to_server, keys.sealing);
  std::vector<std::byte> message, datagram;
  encode(Leave{}, message);
  for (int i = 0; i < kGoodbyes; ++i) {
    sealer.seal(message, datagram);
    port.send(server, datagram);
  }
}

/// Repeats the hello until the server answers, at most for 2 s.
HelloAnswer say_hello(DatagramPort& port, const Peer& server, const Contact& contact) {
  using namespace std::chrono_literals;
  const SteadyClock clock;
  ClientHandshake handshake(contact.key, contact.scene.value_or(kNoScene));
  std::vector<std::byte> datagram;
  std::array<std::byte, kMaxDatagram_bytes> buffer{};
  HelloAnswer answer;
  Time until = clock.now() + 2s, next_hello = clock.now();
  while (!answer.message && clock.now() < until) {
    if (clock.now() >= next_hello) {
      handshake.write_hello(datagram);
      port.send(server, datagram);
      next_hello = clock.now() + kHelloInterval;
    }
    const auto received = port.receive(buffer, std::min(until, next_hello) - clock.now());
    if (!received) continue;
    const Decoded<ServerEnvelope> envelope = open_server_envelope(received->bytes);
    if (!envelope) continue;
    if (const auto* const retry = std::get_if<Retry>(&*envelope)) {
      if (handshake.take(*retry)) next_hello = clock.now();
    } else if (const auto* const refusal = std::get_if<OpenRefusal>(&*envelope)) {
      if (answer.open_refusal || refusal->echo != handshake.echo()) continue;
      answer.open_refusal = *refusal;  // perhaps forged: the true server may still contradict it
    } else if (const auto* const accept = std::get_if<Accept>(&*envelope)) {
      const auto completed = handshake.take(*accept, received->bytes);
      if (!completed) continue;
      answer.message = completed->answer;
      if (std::holds_alternative<Welcome>(completed->answer)) leave(port, server, completed->keys);
    }
  }
  return answer;
}

/// Judges what `server`, an address of `contact.server`, has answered.
Finding judge(const Contact& contact, const Peer& server, const HelloAnswer& answer) {
  if (!answer.message && !answer.open_refusal)
    return {Severity::Fail, "server", contact.server + ": no answer",
            "start rt_server on that machine, with --listen on this port and on an address that is reachable "
            "from here, and open the UDP port in every firewall on the path"};
  const auto fails = [](const Explanation& why) {
    return Finding{Severity::Fail, "server", why.reason, why.cure};
  };
  if (!answer.message) return fails(explain(*answer.open_refusal, contact.key, server));
  const auto* const refusal = std::get_if<Refusal>(&*answer.message);
  const bool compared = !refusal || contact.scene || refusal->reason == RefusalReason::Busy;
  if (refusal && compared) return fails(explain(*refusal, contact.scene.value_or(kNoScene)));
  const std::string scene = compared ? "the same scene" : "scene " + short_form(refusal->scene_hash);
  return {Severity::Ok, "server",
          fmt::format("{}: the server answers, knows the key '{}' and serves {}", contact.server,
                      contact.key.name, scene)};
}

Finding check_server(const Contact& contact) {
  const Expected<std::vector<Peer>> servers = resolve_udp(contact.server);
  if (!servers)
    return failed("server", servers.error(),
                  "give --server the address that rt_server prints; getent hosts HOST must know a name");
  if (contact.key == insecure_key() && !std::ranges::all_of(*servers, is_loopback))
    return {Severity::Fail, "server", "--insecure works on this machine only, not with " + contact.server,
            "omit --insecure and use a key"};
  HelloAnswer answer;
  std::optional<Peer> asked;
  std::optional<Error> unreachable;
  for (const Peer& server : *servers) {
    const Expected<UdpClient> client = connect_udp(server);
    if (!client) {
      unreachable = client.error();
      continue;
    }
    answer = say_hello(*client->port, server, contact);
    asked = server;
    if (answer.message || answer.open_refusal) break;
  }
  if (!asked) return failed("server", *unreachable, "give --server an address that this machine can reach");
  return judge(contact, *asked, answer);
}

/// Whether the server sends its scene to a client that has none.
Finding check_offer(const std::string& server, const SharedKey& key) {
  const auto offer = resolve_tcp(server).and_then([&](const std::vector<Peer>& peers) {
    return ask_offer({.servers = peers, .key = key, .cache = {}, .patience = std::chrono::seconds(3)});
  });
  if (!offer)
    return {
        Severity::Warn, "scene", "the server does not send it: " + offer.error().what,
        "start clients with --scene; or start rt_server without --no-scene-fetch, and open its port for TCP, "
        "too"};
  const std::vector<OfferedFile>& files = offer->offer.files;
  return {Severity::Ok, "scene",
          fmt::format("the server sends it to clients without --scene: {} {}, {:.1f} MB", files.size(),
                      files.size() == 1 ? "file" : "files", static_cast<double>(total_bytes(files)) * 1e-6)};
}

/// The finding about the server that announces itself. `server` becomes its address, or empty.
Finding find_announced(std::string& server) {
  const Expected<FoundServer> found = find_server(server);
  server = found ? address_text(found->address) : "";
  if (!found) {
    const std::string& what = found.error().what;
    const std::size_t colon = what.find(": ");  // before the cure
    return {Severity::Fail, "announcement", what.substr(0, colon),
            colon == what.npos ? "give another name, or --server ADDRESS" : what.substr(colon + 2)};
  }
  return {Severity::Ok, "announcement", "found " + in_words(*found)};
}

}  // namespace

void add_doctor(CLI::App& program, ClientDoctorOptions& options) {
  CLI::App* command =
      program.add_subcommand("doctor",
                             "Checks what the client needs on this machine and at a server, and names "
                             "cures. Exit status 1 if a check FAILs.");
  command->add_option("--key", options.key,
                      "key file to check (default: " + default_key_path().string() + ")");
  command->add_option("--server", options.server,
                      "rt_server to contact: an address, or auto (see vr_client --help)");
  command->add_flag("--insecure", options.insecure, "contact a server that was started with --insecure");
  command->add_option("--scene", options.scene, "scene to load, and to compare with the server's scene");
  add_lighting_options(*command, options.lighting);
}

Findings examine(const ClientDoctorOptions& options) {
  Findings findings{check_build(), check_drawing(), check_window_system(), check_socket_buffers()};
  std::optional<ContentHash> scene;
  if (!options.scene.empty()) {
    const Expected<LitScene> loaded = load_lit_scene(options.scene, options.lighting);
    findings.push_back(check_scene(loaded));
    if (loaded) scene = loaded->scene.hash;
  }
  const std::filesystem::path path =
      options.key.empty() ? default_key_path() : std::filesystem::path(options.key);
  if (!options.insecure) findings.push_back(check_key_file(path, KeyFile::OfClient));
  std::string server = options.server;
  if (is_search(server)) findings.push_back(find_announced(server));
  if (server.empty()) return findings;
  const Expected<SharedKey> key = options.insecure ? insecure_key() : load_key(path);
  if (key) {
    findings.push_back(check_server({server, *key, scene}));
    if (findings.back().severity == Severity::Ok && options.scene.empty())
      findings.push_back(check_offer(server, *key));
  } else {
    findings.push_back({Severity::Fail, "server", server + " was not contacted, because there is no key",
                        "see the line about the key file"});
  }
  return findings;
}

}  // namespace farshade
