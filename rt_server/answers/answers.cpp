#include "rt_server/answers/answers.h"

#include <spdlog/spdlog.h>

#include "rt_server/answers/answer_renderer.h"
#include "rt_server/answers/device_recovery.h"
#include "stereo/video/video.h"

namespace farshade {
namespace {

/// Which lights each pixel of the requested views sees.
class Masks final : public AnswerMaker {
 public:
  explicit Masks(Tracer& tracer) : tracer_(tracer) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    const TraceStats traced = tracer_.trace(job.request, frame_);
    packer.add(frame_, job.request.asked);
    return {.traced = traced};
  }

 private:
  Tracer& tracer_;
  ShadowFrame frame_;
};

}  // namespace

AnswerMakers make_answers(const AnswerContext& context) {
  AnswerMakers makers;
  makers.add(Answer::Masks, make_masks(context.tracer));
  makers.add(Answer::MasksOfPositions, make_position_masks(context));

  const auto renderer = std::make_shared<AnswerRenderer>(context);
  if (const Expected<void> can = renderer->can_draw(); !can) {
    spdlog::info("pictures are not offered: {}", can.error().what);
    return makers;
  }
  const auto recovery = std::make_shared<DeviceRecovery>([renderer] { return renderer->reopen(); });
  makers.add(Answer::GBuffer, recovering(make_gbuffer(renderer), recovery));
  if (!has_video()) {
    spdlog::info("video is not offered: {}", video_version());
    return makers;
  }
  makers.add(Answer::Video, recovering(make_video(renderer), recovery));
  makers.add(Answer::Difference, recovering(make_difference(renderer), recovery));
  return makers;
}

std::unique_ptr<AnswerMaker> make_masks(Tracer& tracer) {
  return std::make_unique<Masks>(tracer);
}

}  // namespace farshade
