// Video: both eyes as they should look, as H.264.
#include "rt_server/answers/painter.h"
#include "rt_server/answers/streams.h"

namespace farshade {
namespace {

class VideoAnswer final : public AnswerMaker {
 public:
  explicit VideoAnswer(Painter& painter) : painter_(painter) {}

  Answered answer(const Job& job, FramePacker& packer) override {
    const Painter::Painted painted = painter_.paint(job.request);
    Answered took = painted.took;
    const Stopwatch reading;
    const PerEye<Image<Rgb8>> eyes = painted.renderer.read_shown();
    took.draw += reading.elapsed();
    took.coding = streams_.code(job, eyes, packer);
    return took;
  }

 private:
  Painter& painter_;
  Streams streams_;
};

}  // namespace

std::unique_ptr<AnswerMaker> make_video(Painter& painter) {
  return std::make_unique<VideoAnswer>(painter);
}

}  // namespace farshade
