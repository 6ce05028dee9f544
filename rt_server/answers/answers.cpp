#include "rt_server/answers/answers.h"

#include <spdlog/spdlog.h>

#include "rt_server/answers/answer_renderer.h"
#include "rt_server/answers/device_recovery.h"
#include "stereo/codec/ask_coder.h"
#include "stereo/codec/mask_block.h"
#include "stereo/frame/tiles.h"
#include "stereo/video/video.h"

namespace farshade {
namespace {

/// Which lights each pixel of the requested views sees, or those lights and blocks that the request asks for.
/// Blocks whose AskSlice has not come are neither traced nor sent.
class Masks final : public RequestHandler {
 public:
  explicit Masks(Tracer& tracer) : tracer_(tracer) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    request_ = job.request;
    const bool is_whole = job.request.answer.slices == 0;
    if (!is_whole) unpack(job);
    const TraceStats traced = tracer_.trace(request_, frame_, job.is_given_up);
    go_on_with(job);
    if (request_.answer.coding == Coding::Lz4) return {.traced = traced, .coding = add_block(packer)};
    if (is_whole)
      packer.add(frame_);
    else
      packer.add(frame_, request_.requested, {come_[0], come_[1]});
    return {.traced = traced};
  }

 private:
  /// Adds both masks as one block.
  Duration add_block(FramePacker& packer) const {
    const Stopwatch coding;
    const std::vector<std::byte> block = pack_mask_block(frame_);
    if (block.empty()) throw AnswerTooLarge(kMostMaskBlock_bytes);
    const Duration packed = coding.elapsed();
    packer.add(request_.frame, request_.frame, full_parts(block));
    return packed;
  }

  void unpack(const Job& job) {
    request_.requested.lights = tracer_.layout().lights;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const std::uint32_t tiles = TileGrid{request_.views[eye].size}.count();
      request_.requested.tiles[eye].assign(tiles, {});
      come_[eye].assign(tiles, 0);
    }
    for (const std::vector<std::byte>& message : job.parts) {
      const Decoded<ClientMessage> decoded = decode_client(message, job.version);
      const auto* const slice = decoded ? std::get_if<AskSlice>(&*decoded) : nullptr;
      if (slice == nullptr || slice->lights != request_.requested.lights ||
          slice->size != request_.views[index_of(slice->eye)].size)
        continue;
      const std::size_t eye = index_of(slice->eye);
      // Of a slice that is damaged, or overlaps an earlier one, no tile has come.
      static_cast<void>(decode_ask_slice(*slice, request_.requested.tiles[eye], come_[eye]));
    }
  }

  Tracer& tracer_;
  FrameRequest request_;
  PerEye<ReceivedTiles> come_;  ///< the tiles whose AskSlice has come
  ShadowFrame frame_;
};

}  // namespace

RequestHandlers make_answers(const AnswerContext& context) {
  RequestHandlers handlers;
  handlers.add(Answer::Masks, make_masks(context.tracer));
  handlers.add(Answer::CubeMask, make_masks(context.tracer));
  handlers.add(Answer::MasksOfPositions, make_position_masks(context));

  const auto renderer = std::make_shared<AnswerRenderer>(context);
  if (const Expected<void> can = renderer->can_draw(); !can) {
    spdlog::info("pictures are not offered: {}", can.error().what);
    return handlers;
  }
  const auto recovery = std::make_shared<DeviceRecovery>([renderer] { return renderer->reopen(); });
  handlers.add(Answer::GBuffer, recovering(make_gbuffer(renderer), recovery));
  if (!has_video()) {
    spdlog::info("video is not offered: {}", video_version());
    return handlers;
  }
  handlers.add(Answer::Video, recovering(make_video(renderer), recovery));
  handlers.add(Answer::Difference, recovering(make_difference(renderer), recovery));
  return handlers;
}

std::unique_ptr<RequestHandler> make_masks(Tracer& tracer) {
  return std::make_unique<Masks>(tracer);
}

}  // namespace farshade
