#include "vr_client/doctor/doctor.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>

#include "stereo/gpu/device.h"
#include "stereo/net/explain.h"
#include "stereo/net/udp.h"
#include "stereo/scene/gltf.h"
#include "stereo/wire/handshake.h"
#include "stereo/wire/key_file.h"

namespace farshade {
namespace {

constexpr const char* kDriverCure =
    "install a driver: sudo apt install libvulkan1 mesa-vulkan-drivers (Mesa draws on the CPU if there is no "
    "GPU), or the driver of the GPU's maker; VK_DRIVER_FILES and VK_ICD_FILENAMES, if set, must name "
    "existing "
    "files";

Finding check_device(const gpu::SurveyedDevice& device) {
  return {Severity::Ok, "Vulkan device",
          fmt::format("{}, {}, Vulkan {}, {}: {}", device.name, device.kind, device.api,
                      device.driver.empty() ? "driver unknown" : device.driver,
                      device.passed_over.empty() ? "used" : "not used, " + device.passed_over)};
}

Findings check_vulkan() {
  const Expected<gpu::Survey> survey = gpu::survey({});
  if (!survey) return {failed("drawing", survey.error(), kDriverCure)};
  Findings findings;
  for (const gpu::SurveyedDevice& device : survey->devices) findings.push_back(check_device(device));
  if (survey->devices.empty())
    findings.push_back({Severity::Fail, "drawing", "no Vulkan device was found", kDriverCure});
  else if (const Expected<gpu::Device> device = gpu::open_device({}); device)
    findings.push_back({Severity::Ok, "drawing", device->name + " opens"});
  else
    findings.push_back(failed("drawing", device.error(), kDriverCure));
  return findings;
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
  const Scene* scene;  ///< null if no scene was named
};

/// What the server answered. An open refusal is not authenticated; an accepted handshake replaces it.
struct HelloAnswer {
  std::optional<OpenRefusal> open_refusal;
  std::optional<ServerMessage> message;  ///< Welcome or Refusal
};

/// Repeats the hello until the server answers, at most for 2 s. The session that the server then holds for
/// this client times out, because the client never uses it.
HelloAnswer say_hello(DatagramPort& port, const Peer& server, const Contact& contact) {
  using namespace std::chrono_literals;
  const SteadyClock clock;
  ClientHandshake handshake(contact.key, contact.scene ? contact.scene->hash : ContentHash{});
  std::vector<std::byte> datagram;
  std::array<std::byte, kMaxDatagram_bytes> buffer{};
  HelloAnswer answer;
  Time until = clock.now() + 2s, next_hello = clock.now();
  while (!answer.message && clock.now() < until) {
    if (clock.now() >= next_hello) {
      handshake.write_hello(datagram);
      port.send(server, datagram);
      next_hello = clock.now() + 250ms;
    }
    const auto received = port.receive(buffer, std::min(until, next_hello) - clock.now());
    if (!received) continue;
    const Decoded<ServerEnvelope> envelope = open_server_envelope(received->bytes);
    if (!envelope) continue;
    if (const auto* const retry = std::get_if<Retry>(&*envelope)) {
      if (handshake.take(*retry)) next_hello = clock.now();
    } else if (const auto* const refusal = std::get_if<OpenRefusal>(&*envelope)) {
      if (answer.open_refusal || refusal->echo != handshake.echo()) continue;
      answer.open_refusal = *refusal;
      until = std::min(until, clock.now() + 500ms);  // for the true server to contradict a forged refusal
    } else if (const auto* const accept = std::get_if<Accept>(&*envelope)) {
      if (auto met = handshake.take(*accept, received->bytes)) answer.message = std::move(met->answer);
    }
  }
  return answer;
}

Finding judge(const Contact& contact, const HelloAnswer& answer) {
  const auto fail_with = [&](std::string found, std::string cure) {
    return Finding{Severity::Fail, "server", contact.server + ": " + std::move(found), std::move(cure)};
  };
  if (!answer.message && !answer.open_refusal)
    return fail_with("no answer",
                     "start rt_server on that machine, with --listen on this port and on an address that is "
                     "reachable from here, and open the UDP port in every firewall on the path");
  if (!answer.message && answer.open_refusal->reason == RefusalReason::VersionMismatch)
    return fail_with(fmt::format("the server speaks protocol version {}, this client version {}",
                                 answer.open_refusal->version, kProtocolVersion),
                     "build both from the same source");
  if (!answer.message)
    return fail_with(
        fmt::format("the server does not know the key '{}'", contact.key.name),
        "add it to the server's ring (rt_server keygen NAME, then restart rt_server), or give --key "
        "the file that was made there; --insecure works only if the server was started with it");
  const std::string reached =
      fmt::format("{}: the server answers and knows the key '{}'", contact.server, contact.key.name);
  const auto* const refusal = std::get_if<Refusal>(&*answer.message);
  if (!refusal) return {Severity::Ok, "server", reached + "; it serves the same scene"};
  if (refusal->reason == RefusalReason::Busy)
    return fail_with("the server has no room for another client",
                     "try again later, or start it with more --sessions");
  const std::string served = short_form(refusal->scene_hash);
  if (!contact.scene)
    return {Severity::Ok, "server",
            fmt::format("{}; it serves scene {} (--scene FILE compares)", reached, served)};
  return fail_with(fmt::format("the server serves scene {}, the client shows scene {} ({})", served,
                               short_form(contact.scene->hash), contact.scene->name),
                   "give both the same scene file");
}

Finding check_server(const Contact& contact) {
  const Expected<UdpClient> client = connect_udp(contact.server);
  if (!client)
    return failed("server", client.error(),
                  "give --server HOST:PORT as rt_server prints it; getent hosts HOST must know the name");
  if (contact.key == insecure_key() && !is_loopback(client->server))
    return {Severity::Fail, "server", "--insecure works on this machine only, not with " + contact.server,
            "omit --insecure and use a key"};
  return judge(contact, say_hello(*client->port, client->server, contact));
}

Findings check_link(const ClientDoctorOptions& options, const Scene* scene) {
  Findings findings;
  Expected<SharedKey> key = insecure_key();
  if (!options.insecure) {
    const std::filesystem::path path =
        options.key.empty() ? default_key_path() : std::filesystem::path(options.key);
    findings.push_back(check_key_file(path, KeyFile::OfClient));
    key = load_key(path);
  }
  findings.push_back(check_socket_buffers());
  if (!options.server.empty() && key)
    findings.push_back(check_server({options.server, *key, scene}));
  else if (!options.server.empty())
    findings.push_back({Severity::Fail, "server",
                        options.server + " was not contacted, because there is no key",
                        "see the line about the key file"});
  return findings;
}

}  // namespace

void add_doctor(CLI::App& program, ClientDoctorOptions& options) {
  CLI::App* command =
      program.add_subcommand("doctor",
                             "Checks what the client needs on this machine and at a server, and names "
                             "cures. Exit status 1 if a check FAILs.");
  command->add_option("--key", options.key,
                      "key file to check (default: " + default_key_path().string() + ")");
  command->add_option("--server", options.server, "address of an rt_server to contact");
  command->add_flag("--insecure", options.insecure, "contact a server that was started with --insecure");
  command->add_option("--scene", options.scene, "scene to load, and to compare with the server's scene");
}

Findings examine(const ClientDoctorOptions& options) {
  Findings findings{check_build()};
  for (Finding& finding : check_vulkan()) findings.push_back(std::move(finding));
  findings.push_back(check_window_system());
  std::optional<Expected<Scene>> scene;
  if (!options.scene.empty()) findings.push_back(check_scene(scene.emplace(load_scene(options.scene))));
  const bool loaded = scene && scene->has_value();
  for (Finding& finding : check_link(options, loaded ? &scene->value() : nullptr))
    findings.push_back(std::move(finding));
  return findings;
}

}  // namespace farshade
