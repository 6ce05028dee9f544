// Difference: what shadows change in both eyes' pictures, around mid-grey, as H.264.
#include "rt_server/answers/painter.h"
#include "rt_server/answers/streams.h"
#include "stereo/draw/difference_picture.h"

namespace farshade {
namespace {

class DifferenceAnswer final : public AnswerMaker {
 public:
  explicit DifferenceAnswer(Painter& painter) : painter_(painter) {}

  Answered answer(const Job& job, FramePacker& packer) override {
    const Painter::Painted painted = painter_.paint(job.request);
    Answered took = painted.took;
    const Stopwatch drawing;
    PerEye<Image<Rgb8>> eyes = painted.renderer.read_shown();
    ShownFrame without = painted.shown;
    without.masks = {};
    painted.renderer.shade_again(without);
    const PerEye<Image<Rgb8>> lit = painted.renderer.read_shown();
    for (std::size_t eye = 0; eye < kEyes; ++eye) eyes[eye] = difference_of(eyes[eye], lit[eye]);
    took.draw += drawing.elapsed();
    took.coding = streams_.code(job, eyes, packer);
    return took;
  }

 private:
  Painter& painter_;
  Streams streams_;
};

}  // namespace

std::unique_ptr<AnswerMaker> make_difference(Painter& painter) {
  return std::make_unique<DifferenceAnswer>(painter);
}

}  // namespace farshade
