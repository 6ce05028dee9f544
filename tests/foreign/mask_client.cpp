/// A client of another project: asks rt_server for the masks of one stereo view and prints how many lights
/// its pixels see. It links the libraries for links and requests, and draws nothing.
#include <bit>
#include <cstdio>

#include "stereo/gltf/gltf.h"
#include "stereo/link/network_link.h"
#include "stereo/net/udp.h"
#include "stereo/requests/request_plan.h"
#include "stereo/sealing/key_file.h"

namespace {

using namespace farshade;

constexpr Duration kPatience = std::chrono::seconds(20), kPeriod = std::chrono::microseconds(13889);

/// A head at the scene's camera.
FrameMoment shown_from(const Scene& scene) {
  FrameMoment shown;
  shown.frame = {1};
  for (const Side side : kSides) {
    const Rigid<Head, Eye> head_from_eye{{1, 0, 0, 0}, {side == Side::Left ? -0.032 : 0.032, 0, 0}};
    View& view = shown.views[index_of(side)];
    view.stage_from_eye =
        scene.camera.value_or(Rigid<Stage, Eye>{}) * Rigid<Eye, Head>{{1, 0, 0, 0}, {}} * head_from_eye;
    view.fov = {-0.8, 0.8, 0.8, -0.8};
    view.size = {256, 256};
  }
  return shown;
}

/// The share of the mask's bits that are set.
double lit_share(const EyeMask& mask) {
  std::uint64_t lit = 0;
  for (std::uint32_t y = 0; y < mask.size().height; ++y)
    for (std::uint32_t x = 0; x < mask.size().width; ++x)
      lit += static_cast<std::uint64_t>(std::popcount(mask.word(x, y, 0)));
  return static_cast<double>(lit) / static_cast<double>(mask.size().pixels() * mask.lights());
}

Expected<void> ask(const char* scene_file, const char* address, const char* key_file) {
  const Expected<Scene> scene = load_scene(scene_file);
  if (!scene) return tl::unexpected(scene.error());
  const Expected<SharedKey> key = load_key(key_file);
  if (!key) return tl::unexpected(key.error());
  const Expected<UdpClient> udp = connect_udp(address);
  if (!udp) return tl::unexpected(udp.error());
  const MaskLayout layout{static_cast<std::uint32_t>(scene->lights.size())};
  const SteadyClock clock;
  NetworkLink link(*udp->port, clock, {udp->server, *key, scene->hash, layout}, 8);
  if (const Expected<void> connected = link.connect(kPatience); !connected) return connected;

  RequestPlan plan{RequestSettings{}};
  const std::optional<FrameRequest> request = plan.ask(shown_from(*scene), kPeriod);
  if (!request) return fail(Fault::Unavailable, "no request is due in the first frame");
  link.request(*request, request->display_time);
  if (!link.wait_for(request->frame, kPatience)) return fail(Fault::Unavailable, "no whole answer came");
  const RequestRecord& record = *link.receiver().find(request->frame);
  std::printf("%ux%u pixels an eye, %u lights, lit: %.4f and %.4f\n", record.masks[0].size().width,
              record.masks[0].size().height, record.masks[0].lights(), lit_share(record.masks[0]),
              lit_share(record.masks[1]));
  return {};
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) return std::fprintf(stderr, "usage: mask_client SCENE HOST:PORT KEY_FILE\n"), 2;
  const farshade::Expected<void> asked = ask(arguments[1], arguments[2], arguments[3]);
  if (!asked) std::fprintf(stderr, "mask_client: %s\n", asked.error().what.c_str());
  return asked ? 0 : 1;
}
