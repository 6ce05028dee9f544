// Delta: the client draws a picture without shadows and adds the server's picture of the difference that
// shadows make, turned to the shown pose (delta encoding of Cuervo et al., "Kahawai: High-Quality Mobile
// Gaming Using GPU Offload", MobiSys 2015). Pixels that the server's picture does not cover have no shadows.
#include "stereo/draw/turn_pass.h"
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/modes/video_stream.h"

namespace farshade {
namespace {

class Delta final : public ModePipeline {
 public:
  explicit Delta(const RunContext& context) : context_(context), stream_(context, Answer::Difference) {}

  const FrameRequest* request(const FrameInputs& inputs) override { return stream_.request(inputs); }
  void collect(const FrameInputs& inputs) override { stream_.collect(inputs); }

  DrawnFrame draw(const FrameInputs& inputs) override {
    const ShownFrame frame{.views = inputs.shown.views, .state = inputs.state, .masks = {}, .carry_over = {}};
    const VideoStream::Picture* const picture = stream_.picture();
    if (picture == nullptr)
      return {.drawn = context_.renderer.draw(frame), .as = ShownAs::Picture, .start_up = true};
    const StereoView& from = picture->request.views;
    return {.drawn = context_.renderer.draw_with_difference(frame, picture->eyes, from),
            .as = ShownAs::Picture,
            .newest = stream_.received(),
            .age = stream_.age(inputs),
            .black = outside_share(from, inputs.shown.views),
            .decoding = stream_.decoding()};
  }

 private:
  const RunContext& context_;
  VideoStream stream_;
};

}  // namespace

std::unique_ptr<ModePipeline> make_delta(const RunContext& context) {
  return std::make_unique<Delta>(context);
}

}  // namespace farshade
