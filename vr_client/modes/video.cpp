// Remote: the server draws both eyes and sends them as video. The client turns the newest picture to the
// shown pose. Pixels that the picture does not cover are black.
//
// Delta: the client draws a picture without shadows and adds the server's picture of the difference that
// shadows make, turned to the shown pose (delta encoding of Cuervo et al., "Kahawai: High-Quality Mobile
// Gaming Using GPU Offload", MobiSys 2015). Pixels that the server's picture does not cover have no shadows.
#include "vr_client/modes/video.h"

#include <stdexcept>
#include <utility>

#include "stereo/draw/turn_pass.h"
#include "vr_client/modes/exchange.h"
#include "vr_client/modes/make_pipeline.h"

namespace farshade {
namespace {

VideoDecoder make_decoder() {
  Expected<VideoDecoder> decoder = VideoDecoder::create();
  if (!decoder) throw std::runtime_error(decoder.error().what);
  return std::move(*decoder);
}

}  // namespace

VideoChain::VideoChain() : decoder_(make_decoder()) {}

const Image<Rgb8>* VideoChain::take(FrameId frame, FrameId after, std::span<const std::byte> unit,
                                    Extent size) {
  const std::optional<FrameId> last = std::exchange(last_, std::nullopt);
  if (after == frame)
    decoder_.reset();  // a key frame depends on no other
  else if (after != last)
    return nullptr;
  const Expected<const Image<Rgb8>*> picture = decoder_.decode(unit);
  if (!picture || (*picture)->size != size) return nullptr;
  last_ = frame;
  return *picture;
}

namespace {

/// The part that both modes share. It requests coded pictures, decodes them in order and requests a key frame
/// after a loss.
class VideoStream {
 public:
  /// `answer` is Video or Difference. Throws if the build has no decoder, which open_client refuses before.
  VideoStream(const RunContext& context, Answer answer);

  const FrameRequest* request(const FrameInputs& inputs);

  /// Decodes the pictures that this frame may use and that have not been decoded yet.
  void collect(const FrameInputs& inputs);

  /// The newest picture and its request.
  struct Picture {
    PerEye<Image<Rgb8>> eyes;
    FrameRequest request;
    Time requested_at;
  };
  /// Null before the first picture.
  [[nodiscard]] const Picture* picture() const { return picture_ ? &*picture_ : nullptr; }

  /// The record of the picture's request; null if it is forgotten.
  [[nodiscard]] const RequestRecord* received() const;
  [[nodiscard]] std::optional<Duration> age(const FrameInputs& inputs) const;
  /// The time that decoding took in this frame.
  [[nodiscard]] Duration decoding() const { return decoding_; }

 private:
  void decode(const RequestRecord& frame);

  const RunContext& context_;
  Answer answer_;
  Exchange exchange_;
  VideoChain chain_;
  std::optional<Picture> picture_;
  Duration decoding_{};
};

VideoStream::VideoStream(const RunContext& context, Answer answer)
    : context_(context), answer_(answer), exchange_(context.link, context.policy, context.settings.request) {}

const FrameRequest* VideoStream::request(const FrameInputs& inputs) {
  const Duration interval = inputs.period * inputs.settings.request.every;
  const FrameRequest* const request =
      exchange_.plan(inputs, {.kind = answer_,
                              .bits_per_second = context_.mode.bits_per_second,
                              .interval = interval,
                              .coding = chain_.next()});
  exchange_.send(inputs);
  return request;
}

void VideoStream::collect(const FrameInputs& inputs) {
  const auto received = exchange_.receive(inputs);
  const Stopwatch watch;
  for (auto oldest_first = received.rbegin(); oldest_first != received.rend(); ++oldest_first) {
    const RequestRecord* const frame = *oldest_first;
    const bool is_newer_picture = !picture_ || is_newer(frame->request.frame, picture_->request.frame);
    if (is_newer_picture && frame->video.complete()) decode(*frame);
  }
  decoding_ = watch.elapsed();
  if (const RequestRecord* const shown = this->received()) exchange_.drawn_with(inputs, *shown);
}

void VideoStream::decode(const RequestRecord& frame) {
  const FrameId id = frame.request.frame;
  const Extent eye = frame.request.views[0].size;
  const Image<Rgb8>* const picture =
      chain_.take(id, frame.video.after, frame.video.unit, side_by_side_size(eye));
  if (picture == nullptr) return;
  picture_ = Picture{two_eyes(*picture, eye), frame.request, frame.origin.requested_at};
}

const RequestRecord* VideoStream::received() const {
  return picture_ ? context_.link->inbox().find(picture_->request.frame) : nullptr;
}

std::optional<Duration> VideoStream::age(const FrameInputs& inputs) const {
  if (!picture_) return std::nullopt;
  return inputs.shown.display_time - picture_->requested_at;
}

class Remote final : public ModePipeline {
 public:
  explicit Remote(const RunContext& context) : context_(context), stream_(context, Answer::Video) {}

  const FrameRequest* request(const FrameInputs& inputs) override { return stream_.request(inputs); }
  void collect(const FrameInputs& inputs) override { stream_.collect(inputs); }

  DrawnFrame draw(const FrameInputs& inputs) override {
    const VideoStream::Picture* const picture = stream_.picture();
    const StereoView& shown = inputs.shown.views;
    if (picture == nullptr) return draw_black(context_.renderer, shown);
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

std::unique_ptr<ModePipeline> make_remote(const RunContext& context) {
  return std::make_unique<Remote>(context);
}

std::unique_ptr<ModePipeline> make_delta(const RunContext& context) {
  return std::make_unique<Delta>(context);
}

}  // namespace farshade
