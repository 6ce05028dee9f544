#include "rt_server/answers/answers.h"

#include <spdlog/spdlog.h>

#include "rt_server/answers/answer_renderer.h"
#include "stereo/video/video.h"

namespace farshade {
namespace {

constexpr std::size_t index_of(Answer answer) {
  return static_cast<std::size_t>(answer);
}

}  // namespace

Answers::Answers(const AnswerContext& ground) : painter_(std::make_unique<AnswerRenderer>(ground)) {
  makers_[index_of(Answer::MasksOfPositions)] = make_position_masks(ground);
  makers_[index_of(Answer::GBuffer)] = make_gbuffer(*painter_);
  makers_[index_of(Answer::Video)] = make_video(*painter_);
  makers_[index_of(Answer::Difference)] = make_difference(*painter_);
}

Answers::~Answers() = default;

AnswerSet Answers::offered() const {
  if (const Expected<void> can = painter_->can_paint(); !can) {
    spdlog::info("no pictures are given: {}", can.error().what);
    return kTracedAnswers;
  }
  if (has_video()) return kEveryAnswer;
  spdlog::info("no video is given: {}", video_version());
  return kUncodedAnswers;
}

AnswerCost Answers::answer(const Job& job, FramePacker& packer) {
  try {
    return makers_[index_of(job.request.wanted.answer)]->answer(job, packer);
  } catch (const std::exception& error) {
    if (error.what() != last_failure_) spdlog::warn("an answer cannot be made: {}", error.what());
    last_failure_ = error.what();
    packer.begin();
    return {};
  }
}

}  // namespace farshade
