// Remote: the server draws both eyes and sends them as video. The client turns the newest picture to the
// shown pose. Pixels that the picture does not cover are black.
#include "stereo/draw/turn_pass.h"
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/modes/video_stream.h"

namespace farshade {
namespace {

class Remote final : public ModePipeline {
 public:
  explicit Remote(const RunContext& context) : context_(context), stream_(context, Answer::Video) {}

  const FrameRequest* request(const FrameInputs& inputs) override { return stream_.request(inputs); }
  void collect(const FrameInputs& inputs) override { stream_.collect(inputs); }

  DrawnFrame draw(const FrameInputs& inputs) override {
    const VideoStream::Picture* const picture = stream_.picture();
    const StereoView& shown = inputs.shown.views;
    if (picture == nullptr) {
      const PerEye<Image<Rgb8>> black{Image<Rgb8>(shown[0].size), Image<Rgb8>(shown[1].size)};
      return {.drawn = context_.renderer.show_turned(black, shown, shown),
              .as = ShownAs::Picture,
              .start_up = true,
              .black = {1.0, 1.0}};
    }
    const StereoView& from = picture->request.views;
    return {.drawn = context_.renderer.show_turned(picture->eyes, from, shown),
            .as = ShownAs::Picture,
            .newest = stream_.received(),
            .age = stream_.age(inputs),
            .black = outside_share(from, shown),
            .decoding = stream_.decoding()};
  }

 private:
  const RunContext& context_;
  VideoStream stream_;
};

}  // namespace

std::unique_ptr<ModePipeline> make_remote(const RunContext& context) {
  return std::make_unique<Remote>(context);
}

}  // namespace farshade
