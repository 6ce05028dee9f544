#include "rt_server/doctor/doctor.h"

#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <thread>

#include "stereo/doctor/checks.h"
#include "stereo/net/udp.h"
#include "stereo/scene/gltf.h"
#include "stereo/tracer/ray_scene.h"
#include "stereo/tracer/tracer.h"
#include "stereo/wire/key_file.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

Finding check_processor() {
  std::string features;
  if (__builtin_cpu_supports("sse4.2") != 0) features += " SSE4.2";
  if (__builtin_cpu_supports("avx2") != 0) features += " AVX2";
  if (__builtin_cpu_supports("avx512f") != 0) features += " AVX-512";
  Finding finding{Severity::Ok, "processor",
                  fmt::format("{} cores,{}", std::thread::hardware_concurrency(),
                              features.empty() ? " no wide vectors" : features)};
  if (__builtin_cpu_supports("avx2") == 0) {
    finding.severity = Severity::Warn;
    finding.cure = "tracing is slow without AVX2: serve fewer clients, or run the server on a newer machine";
  }
  return finding;
}

/// A triangle 2 m ahead of a head that holds a lamp.
Scene lit_triangle() {
  Scene scene;
  scene.name = "a triangle";
  scene.materials.resize(1);
  Mesh mesh;
  mesh.positions = {{-4, -4, -2}, {4, -4, -2}, {0, 4, -2}};
  mesh.normals.assign(3, {0, 0, 1});
  mesh.triangles = {{0, 1, 2}};
  scene.meshes = {mesh};
  scene.nodes.resize(1);
  scene.instances.resize(1);
  scene.lights.resize(1);
  scene.bounds = {{-4, -4, -2}, {4, 4, -2}};
  scene.triangle_count = 1;
  return scene;
}

/// The middle of the triangle is lit, and the sky beside it is not.
bool traces_right(Tracer& tracer) {
  constexpr Extent kSize{33, 33};
  const View view{{}, {.left_rad = -1.2, .right_rad = 1.2, .up_rad = 1.2, .down_rad = -1.2}, kSize};
  ShadowFrame frame;
  tracer.trace({.frame = {1}, .display_time = {}, .scene_time = {}, .views = {view, view}}, frame);
  const EyeMask& mask = frame.masks[0];
  return mask.lit(16, 16, 0) && !mask.lit(0, 0, 0);
}

Finding check_tracer() {
  const Stopwatch watch;
  const Scene scene = lit_triangle();
  Expected<Tracer> tracer = Tracer::create(scene);
  const std::string cure = "reinstall Embree (Debian: libembree-dev), or build this program again";
  if (!tracer) return failed("tracer", tracer.error(), cure);
  if (!traces_right(*tracer))
    return {Severity::Fail, "tracer", "Embree " + embree_version() + " traces a single triangle wrongly",
            cure};
  return {
      Severity::Ok, "tracer",
      fmt::format("Embree {} traces a triangle right, {:.1f} ms", embree_version(), ms_of(watch.elapsed()))};
}

Findings check_served_scene(const std::string& path) {
  const Expected<Scene> scene = load_scene(path);
  Findings findings{check_scene(scene)};
  if (!scene) return findings;
  if (scene->lights.empty()) {
    findings[0].severity = Severity::Fail;
    findings[0].cure =
        "nothing to serve: add lights to it (KHR_lights_punctual), or let clients show it alone";
  }
  const Stopwatch watch;
  if (const Expected<Tracer> tracer = Tracer::create(*scene); !tracer)
    findings.push_back(
        failed("scene in the tracer", tracer.error(), "free memory, or serve a smaller scene"));
  else
    findings.push_back(
        {Severity::Ok, "scene in the tracer", fmt::format("built in {:.1f} ms", ms_of(watch.elapsed()))});
  return findings;
}

/// What says that a firewall is on, as far as one who is not root may read it; and how it is opened.
std::string cure_of_known_firewall(std::uint16_t port) {
  std::ifstream ufw("/etc/ufw/ufw.conf");
  for (std::string line; std::getline(ufw, line);)
    if (line == "ENABLED=yes") return fmt::format("ufw is on: sudo ufw allow {}/udp", port);
  std::error_code ignored;
  if (fs::exists("/run/firewalld", ignored))
    return fmt::format("firewalld is on: sudo firewall-cmd --add-port={}/udp", port);
  return {};
}

Finding check_firewall(const Peer& listen) {
  if (is_loopback(listen))
    return {Severity::Ok, "firewall",
            to_string(listen) +
                " is heard by this machine alone, no firewall is in the way; clients elsewhere "
                "need --listen 0.0.0.0:" +
                std::to_string(listen.port)};
  const std::string known = cure_of_known_firewall(listen.port);
  return {
      Severity::Warn, "firewall",
      "a firewall cannot be seen from here: reading its rules takes root, and others may stand on the way",
      (known.empty() ? "" : known + "; ") + "test with vr_client doctor --server HOST:" +
          std::to_string(listen.port) + " from the client's machine"};
}

Findings check_port(const std::string& address) {
  const auto port = listen_udp(address);
  if (!port) {
    const bool taken = port.error().fault == Fault::Unavailable;
    return {failed("port", port.error(),
                   taken ? "see whose it is with ss -ulpn, stop that program, or --listen on another port"
                         : "--listen on an address of this machine, such as 127.0.0.1:7447 or 0.0.0.0:7447")};
  }
  const Peer local = (*port)->local();
  return {{Severity::Ok, "port", to_string(local) + " is free"}, check_firewall(local)};
}

Finding check_ipv6() {
  if (listen_udp("[::1]:0")) return {Severity::Ok, "IPv6", "there"};
  return {Severity::Warn, "IPv6", "not on this machine: clients come over IPv4 alone",
          "nothing if that is meant, else sudo sysctl -w net.ipv6.conf.all.disable_ipv6=0"};
}

}  // namespace

void add_doctor(CLI::App& program, ServerDoctorOptions& options) {
  CLI::App* command = program.add_subcommand(
      "doctor", "Says what is missing or wrong on this machine, and the cure. Status 1 if anything FAILs.");
  command->add_option("--keys", options.ring,
                      "key ring to look at; " + default_ring_path().string() + " unless told");
  command->add_option("--listen", options.listen, "address and UDP port to try")->capture_default_str();
  command->add_option("--scene", options.scene, "scene to load");
}

Findings examine(const ServerDoctorOptions& options) {
  Findings findings{check_versions(), check_processor(), check_tracer()};
  if (!options.scene.empty())
    std::ranges::move(check_served_scene(options.scene), std::back_inserter(findings));
  findings.push_back(
      check_key_file(options.ring.empty() ? default_ring_path() : fs::path(options.ring), KeyFile::Ring));
  std::ranges::move(check_port(options.listen), std::back_inserter(findings));
  findings.push_back(check_ipv6());
  findings.push_back(check_socket_buffers());
  return findings;
}

}  // namespace farshade
