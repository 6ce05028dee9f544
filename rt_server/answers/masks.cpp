// Masks: which lights each pixel of the requested views sees.
#include "rt_server/answers/answers.h"

namespace farshade {
namespace {

class Masks final : public AnswerMaker {
 public:
  explicit Masks(Tracer& tracer) : tracer_(tracer) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    const TraceStats traced = tracer_.trace(job.request, frame_);
    packer.add(frame_);
    return {.traced = traced};
  }

 private:
  Tracer& tracer_;
  ShadowFrame frame_;
};

}  // namespace

std::unique_ptr<AnswerMaker> make_masks(Tracer& tracer) {
  return std::make_unique<Masks>(tracer);
}

}  // namespace farshade
