// Server-gbuffer: the server draws the G-buffer and traces its masks; the client shades both, as it would its
// own, and turns the picture to the pose it shows. It needs no geometry, and no more of the scene than
// lights.
#include <algorithm>

#include "stereo/draw/turn_pass.h"
#include "stereo/frame/tiles.h"
#include "vr_client/modes/exchange.h"

namespace farshade {
namespace {

class ServerGBuffer final : public Way {
 public:
  explicit ServerGBuffer(const Session& session) : session_(session), exchange_(session) {}

  const TraceRequest* request(const Moment& moment) override {
    const TraceRequest* const asked = exchange_.plan(moment, {.answer = Answer::GBuffer});
    exchange_.send(moment);
    return asked;
  }

  /// The newest of which all has come that will; before there is one, the newest.
  void collect(const Moment& moment) override {
    newest_ = nullptr;
    for (const ReceivedFrame* frame : exchange_.receive(moment)) {
      if (frame->gbuffer.tiles == 0) continue;
      if (newest_ == nullptr) newest_ = frame;
      if (!frame->complete() && !frame->report) continue;
      newest_ = frame;
      break;
    }
  }

  Seen draw(const Moment& moment) override {
    if (newest_ == nullptr) {
      const PerEye<Image<Rgb8>> black{Image<Rgb8>(moment.shown.views[0].size),
                                      Image<Rgb8>(moment.shown.views[1].size)};
      return {.drawn = session_.renderer.show_turned(black, moment.shown.views, moment.shown.views),
              .as = ShownAs::Picture,
              .start_up = true,
              .black = {1.0, 1.0}};
    }
    const TraceRequest& made_for = newest_->request;
    const SceneState state = state_at(session_.scene, made_for.scene_time, made_for.lights);
    const MaskInHand mask{made_for.frame,
                          made_for.display_time,
                          made_for.scene_time,
                          made_for.views,
                          newest_->masks,
                          newest_->known_tiles,
                          std::uint64_t{newest_->tiles_known[0]} << 32 | newest_->tiles_known[1],
                          newest_->light_set_revision};
    DrawTimes drawn = session_.renderer.draw_received(
        covered(newest_->gbuffer),
        {.views = made_for.views, .state = state, .masks = {&mask, 1}, .carry_over = {}});
    const DrawTimes turned = session_.renderer.turn_shown(made_for.views, moment.shown.views);
    drawn.turn += turned.turn;
    drawn.total += turned.total;
    return {.drawn = drawn,
            .as = ShownAs::Picture,
            .newest = newest_,
            .age = exchange_.age(newest_, moment),
            .black = outside_share(made_for.views, moment.shown.views)};
  }

 private:
  /// Pixels of which not all planes have come are no surface.
  const GBufferPlanes& covered(const ReceivedGBuffer& received) {
    if (received.tiles_known == received.tiles) return received.planes;
    partly_ = received.planes;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      PixelPlane& depth = partly_.depth[eye];
      const TileGrid grid{depth.size};
      for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
        if (received.known_tiles[0][eye][tile] != 0 && received.known_tiles[1][eye][tile] != 0) continue;
        const TileRect rect = grid.rect(tile);
        for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
          std::fill_n(depth.words.begin() + y * depth.size.width + rect.x0, rect.x1 - rect.x0, 0u);
      }
    }
    return partly_;
  }

  const Session& session_;
  GBufferPlanes partly_;
  Exchange exchange_;
  const ReceivedFrame* newest_ = nullptr;
};

}  // namespace

std::unique_ptr<Way> make_server_gbuffer(const Session& session) {
  return std::make_unique<ServerGBuffer>(session);
}

}  // namespace farshade
