#include "stereo/doctor/checks.h"

#include <pwd.h>
#include <sodium.h>
#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "stereo/net/explain.h"
#include "stereo/net/udp.h"
#include "stereo/wire/key_file.h"
#include "stereo/wire/slice.h"

namespace farshade {
namespace {

constexpr std::string_view kBuild = FARSHADE_BUILD_TYPE;
#ifdef __clang__
constexpr const char* kCompiler = "clang " __clang_version__;
#else
constexpr const char* kCompiler = "GCC " __VERSION__;
#endif

const char* subject_of(KeyFile kind) {
  return kind == KeyFile::Ring ? "key ring" : "key file";
}

std::string cure_for_none(KeyFile kind) {
  return kind == KeyFile::Ring ? "make a key with rt_server keygen NAME, or name another ring with --keys"
                               : "make one on the server with rt_server keygen NAME and copy it here, or "
                                 "name it with --key";
}

std::string user_name(uid_t user) {
  const passwd* entry = ::getpwuid(user);
  return entry != nullptr ? entry->pw_name : std::to_string(user);
}

/// A key file that is there and was refused with `fault`.
std::string cure_for(Fault fault, KeyFile kind, const std::string& path, const struct stat& status) {
  if (fault != Fault::Unreadable) return "mend that line, or remove the file and " + cure_for_none(kind);
  if (!S_ISREG(status.st_mode))
    return kind == KeyFile::Ring ? "name a file with --keys" : "name a file with --key";
  if (status.st_uid != ::geteuid())
    return "sudo chown " + user_name(::geteuid()) + " " + path + " && chmod 600 " + path;
  return "chmod 600 " + path;
}

/// Bytes that a UDP socket has for `option`, SO_RCVBUF or SO_SNDBUF, once we have asked; 0 if there is none.
int granted_bytes(int option) {
  const int file = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (file < 0) return 0;
  int bytes = kSocketBuffer_bytes;
  socklen_t size = sizeof bytes;
  ::setsockopt(file, SOL_SOCKET, option, &bytes, size);
  if (::getsockopt(file, SOL_SOCKET, option, &bytes, &size) != 0) bytes = 0;
  ::close(file);
  return bytes / 2;  // the kernel doubles what it is asked for, for its own records: socket(7)
}

}  // namespace

Finding check_versions() {
  Finding finding{Severity::Ok, "versions",
                  fmt::format("protocol {}, {} build by {}, libsodium {}, LZ4 {}", kProtocolVersion, kBuild,
                              kCompiler, sodium_version_string(), lz4_version())};
  if (kBuild == "Debug") {
    finding.severity = Severity::Warn;
    finding.cure = "a Debug build is slow: build with cmake --preset release";
  }
  return finding;
}

Finding check_key_file(const std::filesystem::path& path, KeyFile kind) {
  const char* subject = subject_of(kind);
  struct stat status {};
  const bool is_there = ::stat(path.c_str(), &status) == 0;
  const Expected<std::size_t> keys =
      kind == KeyFile::Ring ? load_key_ring(path).map([](const auto& ring) { return ring.size(); })
                            : load_key(path).map([](const auto&) { return std::size_t{1}; });
  if (!keys && (!is_there || keys.error().fault == Fault::Missing))
    return failed(subject, keys.error(), cure_for_none(kind));
  const std::string about =
      fmt::format("mode {:04o}, owner {}", status.st_mode & 07777, user_name(status.st_uid));
  if (!keys) {
    Finding finding =
        failed(subject, keys.error(), cure_for(keys.error().fault, kind, path.string(), status));
    finding.found += " (" + about + ")";
    return finding;
  }
  if (*keys == 0) return {Severity::Fail, subject, path.string() + " holds no key", cure_for_none(kind)};
  return {Severity::Ok, subject,
          fmt::format("{}: {} {}, {}", path.string(), *keys, *keys == 1 ? "key" : "keys", about)};
}

Finding check_scene(const Expected<Scene>& scene) {
  if (!scene)
    return failed("scene", scene.error(),
                  scene.error().fault == Fault::Missing
                      ? "name a .gltf or .glb file that is there with --scene"
                      : "export it again as glTF 2.0, or use another scene");
  return {Severity::Ok, "scene",
          fmt::format("{}: {} triangles, {} lights, scene {}", scene->name, scene->triangle_count,
                      scene->lights.size(), short_form(scene->hash))};
}

Finding check_socket_buffers() {
  const int receive = granted_bytes(SO_RCVBUF), send = granted_bytes(SO_SNDBUF);
  Finding finding{
      Severity::Ok, "socket buffers",
      fmt::format("{} bytes to receive and {} to send, of {} asked", receive, send, kSocketBuffer_bytes)};
  if (std::min(receive, send) < kSocketBuffer_bytes) {
    finding.severity = Severity::Warn;
    finding.cure =
        fmt::format("bursts may be lost: sudo sysctl -w net.core.rmem_max={0} net.core.wmem_max={0}",
                    kSocketBuffer_bytes);
  }
  return finding;
}

}  // namespace farshade
