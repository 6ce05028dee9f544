// A client that holds a valid key and does with it what it likes (insider_tools.h), for scripts/soak. It
// plays until it is ended, also while its server is away.
#include <csignal>
#include <cstdio>

#include "stereo/base/check.h"
#include "stereo/gltf/gltf.h"
#include "stereo/net/udp.h"
#include "tests/integration/insider_tools.h"

using namespace farshade;

namespace {

std::atomic<bool> ended = false;

int failed(const Error& error) {
  std::fprintf(stderr, "insider: %s\n", error.what.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: insider SERVER KEY_FILE SCENE\n");
    return 2;
  }
  for (const int signal : {SIGTERM, SIGINT}) std::signal(signal, [](int) { ended = true; });
  const Expected<UdpClient> udp = connect_udp(std::string_view(argv[1]));
  if (!udp) return failed(udp.error());
  const Expected<SharedKey> key = load_key(argv[2]);
  if (!key) return failed(key.error());
  const Expected<Scene> scene = load_scene(argv[3]);
  if (!scene) return failed(scene.error());
  Welcome served;
  served.scene_hash = scene->hash;
  served.light_count = narrow<std::uint32_t>(scene->lights.size());
  InsiderAttack attack(udp->server, *key, served, udp->port->local());
  attack.run(ended);
  std::printf("insider: %lu datagrams in %lu plays\n", attack.sent(), attack.rounds());
  return 0;
}
