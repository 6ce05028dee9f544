// Video and difference as H.264: the pictures of both eyes, or the difference that shadows make in them, with
// mid-grey for no difference.
#include "rt_server/answers/answer_renderer.h"
#include "rt_server/answers/video_streams.h"
#include "stereo/draw/difference_picture.h"

namespace farshade {
namespace {

using Eyes = PerEye<Image<Rgb8>>;

Eyes with_shadows(const AnswerRenderer::RenderedAnswer& drawn) {
  return drawn.renderer.read_shown();
}

Eyes shadow_difference(const AnswerRenderer::RenderedAnswer& drawn) {
  Eyes eyes = drawn.renderer.read_shown();
  ShownFrame without = drawn.shown;
  without.masks = {};
  drawn.renderer.shade_again(without);
  const Eyes lit = drawn.renderer.read_shown();
  for (std::size_t eye = 0; eye < kEyes; ++eye) eyes[eye] = difference_of(eyes[eye], lit[eye]);
  return eyes;
}

class CodedAnswer final : public AnswerMaker {
 public:
  CodedAnswer(std::shared_ptr<AnswerRenderer> renderer,
              Eyes (*picture)(const AnswerRenderer::RenderedAnswer&))
      : renderer_(std::move(renderer)), picture_(picture) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    const AnswerRenderer::RenderedAnswer drawn = renderer_->draw(job.request);
    AnswerCost cost = drawn.cost;
    const Stopwatch drawing;
    const Eyes eyes = picture_(drawn);
    cost.draw += drawing.elapsed();
    cost.coding = streams_.code(job, eyes, packer);
    return cost;
  }

 private:
  std::shared_ptr<AnswerRenderer> renderer_;
  Eyes (*picture_)(const AnswerRenderer::RenderedAnswer&);
  Streams streams_;
};

}  // namespace

std::unique_ptr<AnswerMaker> make_video(std::shared_ptr<AnswerRenderer> renderer) {
  return std::make_unique<CodedAnswer>(std::move(renderer), with_shadows);
}

std::unique_ptr<AnswerMaker> make_difference(std::shared_ptr<AnswerRenderer> renderer) {
  return std::make_unique<CodedAnswer>(std::move(renderer), shadow_difference);
}

}  // namespace farshade
