#include "vr_client/doctor/doctor.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <iterator>

#include "stereo/doctor/checks.h"
#include "stereo/gpu/device.h"
#include "stereo/net/explain.h"
#include "stereo/net/udp.h"
#include "stereo/scene/gltf.h"
#include "stereo/wire/key_file.h"
#include "vr_client/doctor/probe.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

constexpr Duration kPatience = std::chrono::seconds(2);
constexpr const char* kDriverCure =
    "install a driver: sudo apt install mesa-vulkan-drivers (it draws on the CPU where there is no GPU), or "
    "the "
    "GPU maker's; VK_DRIVER_FILES and VK_ICD_FILENAMES, where set, must name what is there";

Finding check_device(const gpu::SurveyedDevice& device) {
  Finding finding{Severity::Ok, "Vulkan device",
                  fmt::format("{}, {}, Vulkan {}, {}: ", device.name, device.kind, device.api,
                              device.driver.empty() ? "driver unknown" : device.driver)};
  finding.found += device.passed_over.empty() ? "taken" : "not taken, " + device.passed_over;
  return finding;
}

/// That a device is there is one thing, that it can be opened another.
Finding check_opening(const gpu::Survey& survey) {
  const auto none = std::ranges::none_of(survey.devices, [](const auto& d) { return d.passed_over.empty(); });
  if (survey.devices.empty()) return {Severity::Fail, "drawing", "no Vulkan device was found", kDriverCure};
  if (none) return {Severity::Fail, "drawing", "no Vulkan device can be used", kDriverCure};
  const Expected<gpu::Device> device = gpu::open_device({});
  if (!device) return failed("drawing", device.error(), kDriverCure);
  return {Severity::Ok, "drawing", device->name + " opens"};
}

Findings check_vulkan() {
  const Expected<gpu::Survey> survey = gpu::survey({});
  if (!survey)
    return {failed("Vulkan loader", survey.error(),
                   std::string("sudo apt install libvulkan1, and ") + kDriverCure)};
  Findings findings{{Severity::Ok, "Vulkan loader", survey->loader}};
  std::ranges::transform(survey->devices, std::back_inserter(findings), check_device);
  findings.push_back(check_opening(*survey));
  if (survey->validation == gpu::Validation::On)
    findings.push_back({Severity::Ok, "Vulkan validation layers", "there"});
  else
    findings.push_back({Severity::Warn, "Vulkan validation layers",
                        "not there; only --validate and the tests need them",
                        "sudo apt install vulkan-validationlayers"});
  return findings;
}

Finding check_window_system() {
  for (const char* name : {"WAYLAND_DISPLAY", "DISPLAY"})
    if (const char* value = std::getenv(name); value != nullptr && *value != '\0')
      return {Severity::Ok, "window system", fmt::format("{}={}", name, value)};
  return {Severity::Warn, "window system",
          "neither WAYLAND_DISPLAY nor DISPLAY is set: pictures go to files, only a preview needs a window",
          "run it in a desktop session, or set DISPLAY"};
}

/// What the client would say hello with.
struct Visit {
  std::string server;
  SharedKey key;
  const Scene* scene = nullptr;  ///< null: none was named
};

std::string version_words(const Probed& probed) {
  return fmt::format("the server speaks protocol version {}, this client {}", probed.version,
                     kProtocolVersion);
}

/// What `probed` says of reachability, key and version.
Finding judge_server(const Visit& visit, const Probed& probed) {
  const auto says = [&](Severity severity, std::string found, std::string cure) {
    return Finding{severity, "server", visit.server + ": " + std::move(found), std::move(cure)};
  };
  switch (probed.answer) {
    case ServerAnswer::PortClosed:
      return says(
          Severity::Fail, "that machine answers, but nobody listens on this UDP port",
          "start rt_server there, with --listen on that port and on an address that is not 127.0.0.1");
    case ServerAnswer::Nothing:
      return says(
          Severity::Fail, "no answer",
          "see that rt_server runs there, that it listens on this address and port (--listen), and that "
          "no firewall drops UDP on the way (open the port on the server's machine)");
    case ServerAnswer::OtherVersion:
      return says(Severity::Fail, version_words(probed), "build both from the same source");
    case ServerAnswer::UnknownKey:
      return says(
          Severity::Fail, "it does not know the key '" + visit.key.name + "'",
          "add it to the server's ring (rt_server keygen NAME, then restart rt_server), or give --key the "
          "file that was made there; --insecure fits a server that was started so, and no other");
    case ServerAnswer::OtherScene:
      if (visit.scene)
        return says(Severity::Fail,
                    fmt::format("it serves scene {}, not {} ({})", short_form(probed.scene_hash),
                                short_form(visit.scene->hash), visit.scene->name),
                    "give both the same scene file");
      return says(
          Severity::Ok,
          fmt::format("reachable, key '{}' is known, protocol version {}; it serves scene {} (--scene FILE "
                      "compares)",
                      visit.key.name, kProtocolVersion, short_form(probed.scene_hash)),
          "");
    case ServerAnswer::Busy:
      return says(Severity::Fail, "it has no room for another client",
                  "try again later, or start it with more --sessions");
    case ServerAnswer::Welcomed:
      break;
  }
  return says(Severity::Ok,
              fmt::format("reachable, key '{}' is known, protocol version {}, the same scene", visit.key.name,
                          kProtocolVersion),
              "");
}

Findings check_server(const Visit& visit) {
  const Expected<UdpClient> client = connect_udp(visit.server);
  if (!client)
    return {failed("server", client.error(),
                   "give --server HOST:PORT as rt_server prints it; see that the name is "
                   "known here: getent hosts HOST")};
  if (visit.key == insecure_key() && !is_loopback(client->server))
    return {{Severity::Fail, "server", "--insecure talks to this machine alone, not to " + visit.server,
             "leave --insecure away, and use a key"}};
  const ContentHash hash = visit.scene ? visit.scene->hash : ContentHash{};
  const Probed probed = probe_server(*client->port, client->server, visit.key, hash, kPatience);
  Findings findings{{Severity::Ok, "server address", visit.server + " is " + to_string(client->server)},
                    judge_server(visit, probed)};
  if (probed.round_trip)
    findings.push_back({Severity::Ok, "path to the server",
                        fmt::format("datagrams of {} bytes get there, round trip {:.2f} ms",
                                    kMaxDatagram_bytes, ms_of(*probed.round_trip))});
  return findings;
}

Findings check_link(const ClientDoctorOptions& options, const Scene* scene) {
  Findings findings;
  Expected<SharedKey> key = insecure_key();
  if (!options.insecure) {
    const fs::path path = options.key.empty() ? default_key_path() : fs::path(options.key);
    findings.push_back(check_key_file(path, KeyFile::OfClient));
    key = load_key(path);
  }
  findings.push_back(check_socket_buffers());
  if (options.server.empty()) return findings;
  if (key)
    std::ranges::move(check_server({options.server, *key, scene}), std::back_inserter(findings));
  else
    findings.push_back({Severity::Fail, "server", options.server + " cannot be asked without a key",
                        "see the key file above"});
  return findings;
}

}  // namespace

void add_doctor(CLI::App& program, ClientDoctorOptions& options) {
  CLI::App* command = program.add_subcommand("doctor",
                                             "Says what is missing or wrong on this machine or at a server, "
                                             "and the cure. Status 1 if anything FAILs.");
  command->add_option("--key", options.key,
                      "key file to look at; " + default_key_path().string() + " unless told");
  command->add_option("--server", options.server, "address of an rt_server to try");
  command->add_flag("--insecure", options.insecure, "the server was started so: no key is needed");
  command->add_option("--scene", options.scene, "scene to load, and to compare with the server's");
}

Findings examine(const ClientDoctorOptions& options) {
  Findings findings{check_versions()};
  std::ranges::move(check_vulkan(), std::back_inserter(findings));
  findings.push_back(check_window_system());
  Expected<Scene> scene = Scene{};
  if (!options.scene.empty()) {
    scene = load_scene(options.scene);
    findings.push_back(check_scene(scene));
  }
  const bool compares = !options.scene.empty() && scene;
  std::ranges::move(check_link(options, compares ? &*scene : nullptr), std::back_inserter(findings));
  return findings;
}

}  // namespace farshade
