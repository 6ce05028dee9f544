// Server-gbuffer: the server draws the G-buffer and traces its masks. The client shades them with the same
// passes as its own G-buffer, and turns the picture to the shown pose. Of the scene it needs only the lights.
#include <algorithm>

#include "stereo/frame/tiles.h"
#include "stereo/reproject/timewarp_pass.h"
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/modes/masks.h"

namespace farshade {
namespace {

class ServerGBuffer final : public ModePipeline {
 public:
  explicit ServerGBuffer(const RunContext& context)
      : context_(context), mask_stream_(context.link, context.policy, context.settings.request) {}

  void draw_ahead(const FrameInputs& inputs) override {
    const StereoView& views = inputs.shown.views;
    GBufferPlanes empty;
    for (const PlaneKind kind : kGBufferKinds)
      for (PixelPlane& plane : planes_of(empty, kind))
        plane = {views[0].size, kind == PlaneKind::BaseColor ? 3u : 4u};
    context_.renderer.draw_received(empty,
                                    {.views = views, .state = inputs.state, .masks = {}, .reprojection = {}});
    context_.renderer.timewarp_shown(views, views);
  }

  std::optional<FrameRequest> request(const FrameInputs& inputs) override {
    std::optional<FrameRequest> request = mask_stream_.plan(inputs, {.kind = Answer::GBuffer});
    if (request) mask_stream_.send(inputs, *request);
    return request;
  }

  /// Takes the newest answer that is complete or whose report has come; before there is one, the newest.
  void collect(const FrameInputs& inputs) override {
    newest_ = nullptr;
    for (const RequestRecord* frame : mask_stream_.receive(inputs)) {
      if (frame->gbuffer.tiles == 0) continue;
      if (newest_ == nullptr) newest_ = frame;
      if (!frame->complete() && !frame->report) continue;
      newest_ = frame;
      break;
    }
  }

  DrawnFrame draw(const FrameInputs& inputs) override {
    if (newest_ == nullptr) return draw_black(context_.renderer, inputs.shown.views);
    const FrameRequest& made_for = newest_->request;
    SceneState state = state_at(context_.scene, made_for.scene_time, made_for.lights);
    for (std::size_t i = 0; i < state.light_set.lights.size(); ++i)  // as bright as now
      state.light_set.lights[i].intensity = inputs.state.light_set.lights[i].intensity;
    state.light_set.exposure = inputs.state.light_set.exposure;
    const TracedMask mask = mask_of(*newest_);
    context_.renderer.draw_received(
        covered(newest_->gbuffer),
        {.views = made_for.views, .state = state, .masks = {&mask, 1}, .reprojection = {}});
    context_.renderer.timewarp_shown(made_for.views, inputs.shown.views);
    return {.as = ShownAs::Picture,
            .newest = newest_,
            .age = age_of(*newest_, inputs),
            .black = outside_share(made_for.views, inputs.shown.views)};
  }

 private:
  /// The planes, with a depth of "nothing" in tiles of which not all planes have come.
  const GBufferPlanes& covered(const ReceivedGBuffer& received) {
    if (received.tiles_known == received.tiles) return received.planes;
    partly_ = received.planes;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      PixelPlane& depth = partly_.depth[eye];
      const TileGrid grid{depth.size};
      for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
        if (received.received_tiles[0][eye][tile] != 0 && received.received_tiles[1][eye][tile] != 0)
          continue;
        const TileRect rect = grid.rect(tile);
        for (std::uint32_t y = rect.y0; y < rect.y1; ++y)
          std::fill_n(&depth.words[std::size_t{y} * depth.size.width + rect.x0], rect.x1 - rect.x0, 0u);
      }
    }
    return partly_;
  }

  const RunContext& context_;
  GBufferPlanes partly_;
  MaskStream mask_stream_;
  const RequestRecord* newest_ = nullptr;
};

}  // namespace

std::unique_ptr<ModePipeline> make_server_gbuffer(const RunContext& context) {
  return std::make_unique<ServerGBuffer>(context);
}

}  // namespace farshade
