// G-buffer: base colour, normal and depth of the requested views, and their masks.
#include "rt_server/answers/answer_renderer.h"

namespace farshade {
namespace {

class GBufferAnswer final : public RequestHandler {
 public:
  explicit GBufferAnswer(std::shared_ptr<AnswerRenderer> renderer) : renderer_(std::move(renderer)) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    const AnswerRenderer::RenderedAnswer drawn = renderer_->draw(job);
    go_on_with(job);
    const Stopwatch reading;
    drawn.renderer.read_gbuffer(planes_);
    AnswerCost cost = drawn.cost;
    cost.draw += reading.elapsed();
    go_on_with(job);
    packer.add(drawn.frame);
    packer.add(job.request.frame, planes_);
    return cost;
  }

 private:
  std::shared_ptr<AnswerRenderer> renderer_;
  GBufferPlanes planes_;
};

}  // namespace

std::unique_ptr<RequestHandler> make_gbuffer(std::shared_ptr<AnswerRenderer> renderer) {
  return std::make_unique<GBufferAnswer>(std::move(renderer));
}

}  // namespace farshade
