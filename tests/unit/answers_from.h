/// Answers that test functions make, instead of a tracer and a renderer.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "rt_server/work/request_handlers.h"
#include "tests/support/manual_clock.h"

namespace farshade {

class AnswerFrom final : public RequestHandler {
 public:
  using Function = std::function<AnswerCost(const Job&, FramePacker&)>;
  explicit AnswerFrom(Function function) : function_(std::move(function)) {}
  AnswerCost answer(const Job& job, FramePacker& packer) override { return function_(job, packer); }

 private:
  Function function_;
};

/// Offers `answers`. `function` makes each of them.
[[nodiscard]] inline RequestHandlers answers_from(AnswerSet answers, const AnswerFrom::Function& function) {
  RequestHandlers handlers;
  for (std::uint8_t i = 0; i < kAnswers; ++i)
    if (const auto answer = static_cast<Answer>(i); (answers & set_of(answer)) != 0)
      handlers.add(answer, std::make_unique<AnswerFrom>(function));
  return handlers;
}

/// Offers masks. `trace` fills the frame, whose buffers are reused.
[[nodiscard]] inline RequestHandlers masks_from(
    std::function<TraceStats(const FrameRequest&, ShadowFrame&)> trace) {
  const auto make = [trace = std::move(trace), frame = std::make_shared<ShadowFrame>()](const Job& job,
                                                                                        FramePacker& packer) {
    const TraceStats traced = trace(job.request, *frame);
    packer.add(*frame);
    return AnswerCost{.traced = traced};
  };
  return answers_from(set_of(Answer::Masks), make);
}

}  // namespace farshade
