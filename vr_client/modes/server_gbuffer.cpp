// Server-gbuffer: the server draws the G-buffer and traces its masks; the client shades both, as it would its
// own, and turns the picture to the pose it shows. It needs no geometry, and no more of the scene than
// lights.
#include <algorithm>

#include "stereo/draw/turn_pass.h"
#include "stereo/frame/tiles.h"
#include "vr_client/modes/exchange.h"

namespace farshade {
namespace {

class ServerGBuffer final : public ModePipeline {
 public:
  explicit ServerGBuffer(const RunContext& context) : context_(context), exchange_(context) {}

  const FrameRequest* request(const FrameInputs& inputs) override {
    const FrameRequest* const asked = exchange_.plan(inputs, {.answer = Answer::GBuffer});
    exchange_.send(inputs);
    return asked;
  }

  /// The newest of which all has come that will; before there is one, the newest.
  void collect(const FrameInputs& inputs) override {
    newest_ = nullptr;
    for (const ReceivedFrame* frame : exchange_.receive(inputs)) {
      if (frame->gbuffer.tiles == 0) continue;
      if (newest_ == nullptr) newest_ = frame;
      if (!frame->complete() && !frame->report) continue;
      newest_ = frame;
      break;
    }
  }

  DrawnFrame draw(const FrameInputs& inputs) override {
    if (newest_ == nullptr) {
      const PerEye<Image<Rgb8>> black{Image<Rgb8>(inputs.shown.views[0].size),
                                      Image<Rgb8>(inputs.shown.views[1].size)};
      return {.drawn = context_.renderer.show_turned(black, inputs.shown.views, inputs.shown.views),
              .as = ShownAs::Picture,
              .start_up = true,
              .black = {1.0, 1.0}};
    }
    const FrameRequest& made_for = newest_->request;
    const SceneState state = state_at(context_.scene, made_for.scene_time, made_for.lights);
    const TracedMask mask{made_for.frame,
                          made_for.display_time,
                          made_for.scene_time,
                          made_for.views,
                          newest_->masks,
                          newest_->known_tiles,
                          std::uint64_t{newest_->tiles_known[0]} << 32 | newest_->tiles_known[1],
                          newest_->light_set_revision};
    DrawTimes drawn = context_.renderer.draw_received(
        covered(newest_->gbuffer),
        {.views = made_for.views, .state = state, .masks = {&mask, 1}, .carry_over = {}});
    const DrawTimes turned = context_.renderer.turn_shown(made_for.views, inputs.shown.views);
    drawn.turn += turned.turn;
    drawn.total += turned.total;
    return {.drawn = drawn,
            .as = ShownAs::Picture,
            .newest = newest_,
            .age = exchange_.age(newest_, inputs),
            .black = outside_share(made_for.views, inputs.shown.views)};
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

  const RunContext& context_;
  GBufferPlanes partly_;
  Exchange exchange_;
  const ReceivedFrame* newest_ = nullptr;
};

}  // namespace

std::unique_ptr<ModePipeline> make_server_gbuffer(const RunContext& context) {
  return std::make_unique<ServerGBuffer>(context);
}

}  // namespace farshade
