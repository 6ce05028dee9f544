// G-buffer: base colour, normal and depth as they were drawn, and the masks that go with them.
#include "rt_server/answers/answer_renderer.h"

namespace farshade {
namespace {

class GBufferAnswer final : public AnswerMaker {
 public:
  explicit GBufferAnswer(AnswerRenderer& painter) : painter_(painter) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    const AnswerRenderer::RenderedAnswer painted = painter_.paint(job.request);
    const Stopwatch reading;
    painted.renderer.read_gbuffer(planes_);
    AnswerCost took = painted.took;
    took.draw += reading.elapsed();
    packer.add(painted.frame);
    packer.add(job.request.frame, planes_);
    return took;
  }

 private:
  AnswerRenderer& painter_;
  GBufferPlanes planes_;
};

}  // namespace

std::unique_ptr<AnswerMaker> make_gbuffer(AnswerRenderer& painter) {
  return std::make_unique<GBufferAnswer>(painter);
}

}  // namespace farshade
