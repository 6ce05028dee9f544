// Video and difference: both eyes as they should look, or what shadows change in them around mid-grey, as
// H.264.
#include "rt_server/answers/answer_renderer.h"
#include "rt_server/answers/video_streams.h"
#include "stereo/draw/difference_picture.h"

namespace farshade {
namespace {

using Eyes = PerEye<Image<Rgb8>>;

Eyes as_drawn(const AnswerRenderer::RenderedAnswer& painted) {
  return painted.renderer.read_shown();
}

Eyes what_shadows_change(const AnswerRenderer::RenderedAnswer& painted) {
  Eyes eyes = painted.renderer.read_shown();
  ShownFrame without = painted.shown;
  without.masks = {};
  painted.renderer.shade_again(without);
  const Eyes lit = painted.renderer.read_shown();
  for (std::size_t eye = 0; eye < kEyes; ++eye) eyes[eye] = difference_of(eyes[eye], lit[eye]);
  return eyes;
}

class CodedAnswer final : public AnswerMaker {
 public:
  CodedAnswer(AnswerRenderer& painter, Eyes (*picture)(const AnswerRenderer::RenderedAnswer&))
      : painter_(painter), picture_(picture) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    const AnswerRenderer::RenderedAnswer painted = painter_.paint(job.request);
    AnswerCost took = painted.took;
    const Stopwatch drawing;
    const Eyes eyes = picture_(painted);
    took.draw += drawing.elapsed();
    took.coding = streams_.code(job, eyes, packer);
    return took;
  }

 private:
  AnswerRenderer& painter_;
  Eyes (*picture_)(const AnswerRenderer::RenderedAnswer&);
  Streams streams_;
};

}  // namespace

std::unique_ptr<AnswerMaker> make_video(AnswerRenderer& painter) {
  return std::make_unique<CodedAnswer>(painter, as_drawn);
}

std::unique_ptr<AnswerMaker> make_difference(AnswerRenderer& painter) {
  return std::make_unique<CodedAnswer>(painter, what_shadows_change);
}

}  // namespace farshade
