#include "stereo/doctor/checks.h"

#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "stereo/net/explain.h"
#include "stereo/net/udp.h"
#include "stereo/sealing/envelope.h"
#include "stereo/sealing/key_file.h"

namespace farshade {
namespace {

constexpr std::string_view kBuild = FARSHADE_BUILD_TYPE;

/// The buffer size in bytes that the kernel grants for `option`, SO_RCVBUF or SO_SNDBUF; 0 without a socket.
int granted_bytes(int option) {
  const int file = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (file < 0) return 0;
  int bytes = kSocketBuffer_bytes;
  socklen_t size = sizeof bytes;
  ::setsockopt(file, SOL_SOCKET, option, &bytes, size);
  if (::getsockopt(file, SOL_SOCKET, option, &bytes, &size) != 0) bytes = 0;
  ::close(file);
  return bytes / 2;  // the kernel doubles the size for its own bookkeeping: socket(7)
}

}  // namespace

Finding failed(std::string subject, const Error& error, std::string cure) {
  return {Severity::Fail, std::move(subject), error.what, std::move(cure)};
}

int report(const Findings& findings) {
  constexpr std::array names{"ok", "warn", "FAIL"};
  for (const Finding& finding : findings)
    fmt::print("{:<5} {}: {}{}{}\n", names[static_cast<std::size_t>(finding.severity)], finding.subject,
               finding.found, finding.cure.empty() ? "" : "; cure: ", finding.cure);
  return std::ranges::count(findings, Severity::Fail, &Finding::severity) > 0 ? 1 : 0;
}

Finding check_build() {
  const std::string found = fmt::format("{}, protocol version {}", kBuild, kProtocolVersion);
  if (kBuild != "Debug") return {Severity::Ok, "build", found};
  return {Severity::Warn, "build", found, "a Debug build is slow: build with cmake --preset release"};
}

Finding check_key_file(const std::filesystem::path& path, KeyFile kind) {
  const bool is_ring = kind == KeyFile::Ring;
  const char* const subject = is_ring ? "key ring" : "key file";
  const Expected<std::size_t> keys =
      is_ring ? load_key_ring(path).map([](const auto& ring) { return ring.size(); })
              : load_key(path).map([](const auto&) { return std::size_t{1}; });
  if (keys && *keys > 0)
    return {Severity::Ok, subject,
            fmt::format("{}: {} {}", path.string(), *keys, *keys == 1 ? "key" : "keys")};
  if (!keys && keys.error().fault == Fault::Unreadable)
    return failed(
        subject, keys.error(),
        "make it a file that only you may read: chown it to yourself and chmod 600 " + path.string());
  return {Severity::Fail, subject, keys ? path.string() + " contains no key" : keys.error().what,
          is_ring ? "bring the key of a client with rt_server pair, make one with rt_server keygen NAME, or "
                    "name another ring with --keys"
                  : "bring one to the server with vr_client pair (rt_server pair shows the code there), copy "
                    "one that rt_server keygen NAME made there, or name another "
                    "key file with --key"};
}

Finding check_scene(const Expected<LitScene>& lit) {
  if (!lit) return failed("scene", lit.error(), "name a readable glTF 2.0 file (.gltf or .glb) with --scene");
  const Scene& scene = lit->scene;
  Finding finding{Severity::Ok, "scene",
                  fmt::format("{}: {} triangles, {} lights, scene {}", scene.name, scene.triangle_count,
                              scene.lights.size(), short_form(scene.hash))};
  for (const std::string& note : lit->notes) finding.found += "; " + note;
  return finding;
}

Finding check_socket_buffers() {
  const int bytes = std::min(granted_bytes(SO_RCVBUF), granted_bytes(SO_SNDBUF));
  const std::string found = fmt::format("{} bytes granted of {} requested", bytes, kSocketBuffer_bytes);
  if (bytes >= kSocketBuffer_bytes) return {Severity::Ok, "socket buffers", found};
  return {Severity::Warn, "socket buffers", found,
          fmt::format("bursts may be lost: sudo sysctl -w net.core.rmem_max={0} net.core.wmem_max={0}",
                      kSocketBuffer_bytes)};
}

}  // namespace farshade
