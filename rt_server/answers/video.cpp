// Video and difference: both eyes as they should look, or what shadows change in them around mid-grey, as
// H.264.
#include "rt_server/answers/painter.h"
#include "rt_server/answers/streams.h"
#include "stereo/draw/difference_picture.h"

namespace farshade {
namespace {

using Eyes = PerEye<Image<Rgb8>>;

Eyes as_drawn(const Painter::Painted& painted) {
  return painted.renderer.read_shown();
}

Eyes what_shadows_change(const Painter::Painted& painted) {
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
  CodedAnswer(Painter& painter, Eyes (*picture)(const Painter::Painted&))
      : painter_(painter), picture_(picture) {}

  Answered answer(const Job& job, FramePacker& packer) override {
    const Painter::Painted painted = painter_.paint(job.request);
    Answered took = painted.took;
    const Stopwatch drawing;
    const Eyes eyes = picture_(painted);
    took.draw += drawing.elapsed();
    took.coding = streams_.code(job, eyes, packer);
    return took;
  }

 private:
  Painter& painter_;
  Eyes (*picture_)(const Painter::Painted&);
  Streams streams_;
};

}  // namespace

std::unique_ptr<AnswerMaker> make_video(Painter& painter) {
  return std::make_unique<CodedAnswer>(painter, as_drawn);
}

std::unique_ptr<AnswerMaker> make_difference(Painter& painter) {
  return std::make_unique<CodedAnswer>(painter, what_shadows_change);
}

}  // namespace farshade
