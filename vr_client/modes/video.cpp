// Remote: the server draws both eyes and sends them as video. The client turns the newest picture to the
// shown pose. Pixels that the picture does not cover are black.
//
// Delta: the client draws a picture without shadows and adds the server's picture of the difference that
// shadows make, turned to the shown pose (delta encoding of Cuervo et al., "Kahawai: High-Quality Mobile
// Gaming Using GPU Offload", MobiSys 2015). Pixels that the server's picture does not cover have no shadows.
#include "vr_client/modes/video.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "stereo/reproject/timewarp_pass.h"
#include "vr_client/modes/make_pipeline.h"
#include "vr_client/modes/mask_stream.h"

namespace farshade {
namespace {

std::unique_ptr<VideoDecoder> make_decoder() {
  Expected<std::unique_ptr<VideoDecoder>> decoder = VideoDecoder::create();
  if (!decoder) throw std::runtime_error(decoder.error().what);
  return std::move(*decoder);
}

}  // namespace

VideoChain::VideoChain() : decoder_(make_decoder()) {}

const Image<Rgb8>* VideoChain::take(FrameId frame, FrameId after, std::span<const std::byte> unit,
                                    Extent size) {
  const std::optional<Extent> last = std::exchange(size_, std::nullopt);
  if (after == frame)
    decoder_->reset();  // a key frame depends on no other
  else if (last != size)
    return nullptr;  // the key frame of this size is lost
  const Expected<const Image<Rgb8>*> picture = decoder_->decode(unit, size);
  if (!picture) return nullptr;
  size_ = size;
  return *picture;
}

namespace {

/// The part that both modes share. It requests coded pictures and decodes them in order. It requests a key
/// frame only if the decoder cannot go on without one.
class VideoStream {
 public:
  /// `answer` is Video or Difference. Throws if the build has no decoder, which open_client refuses before.
  VideoStream(const RunContext& context, Answer answer);

  std::optional<FrameRequest> request(const FrameInputs& inputs);

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
  [[nodiscard]] Coding needed_coding() const;
  [[nodiscard]] bool is_due(const RequestRecord& frame, std::span<const RequestRecord* const> newer);
  void decode(const RequestRecord& frame);

  const RunContext& context_;
  Answer answer_;
  MaskStream mask_stream_;
  VideoChain chain_;
  std::optional<Picture> picture_;
  std::optional<FrameId>
      key_asked_;  ///< the frame that requested a key frame, until its unit has been decoded
  std::optional<FrameId> reported_;  ///< the newest frame whose report has come before all of its parts
  std::optional<FrameId> tried_;     ///< the newest frame that was given to the decoder
  Duration decoding_{};
};

VideoStream::VideoStream(const RunContext& context, Answer answer)
    : context_(context),
      answer_(answer),
      mask_stream_(context.link, context.policy, context.settings.request) {}

std::optional<FrameRequest> VideoStream::request(const FrameInputs& inputs) {
  const Duration interval = inputs.period * std::max(inputs.settings.request.every, 1u);
  std::optional<FrameRequest> request =
      mask_stream_.plan(inputs, {.kind = answer_,
                                 .bits_per_second = context_.mode.bits_per_second,
                                 .interval = interval,
                                 .coding = needed_coding()});
  if (!request) return request;
  if (request->answer.coding == Coding::Alone) key_asked_ = request->frame;
  mask_stream_.send(inputs, *request);
  return request;
}

/// While a requested key frame may still come, the pictures after it need no other.
Coding VideoStream::needed_coding() const {
  return key_asked_ ? Coding::AfterLast : chain_.next();
}

void VideoStream::collect(const FrameInputs& inputs) {
  const auto received = mask_stream_.receive(inputs);
  const Stopwatch watch;
  for (std::size_t newer = received.size(); newer-- > 0;) {
    const RequestRecord& frame = *received[newer];
    if (tried_ && !is_newer(frame.request.frame, *tried_)) continue;
    if (is_due(frame, received.first(newer))) decode(frame);
  }
  decoding_ = watch.elapsed();
  if (const RequestRecord* const shown = this->received()) mask_stream_.drawn_with(inputs, *shown);
}

/// A unit that lacks parts is decoded when a newer one is complete or reported, or one display frame after
/// its report. The report was sent last, but jitter may deliver it before the parts.
bool VideoStream::is_due(const RequestRecord& frame, std::span<const RequestRecord* const> newer) {
  const auto is_over = [](const RequestRecord* record) { return record->video.complete() || record->report; };
  if (frame.video.complete() || std::ranges::any_of(newer, is_over)) return true;
  if (!frame.report) return false;
  return std::exchange(reported_, frame.request.frame) == frame.request.frame;
}

void VideoStream::decode(const RequestRecord& frame) {
  const FrameId id = frame.request.frame;
  tried_ = id;
  if (key_asked_ && !is_newer(*key_asked_, id)) key_asked_.reset();
  const Extent eye = frame.request.views[0].size;
  const Image<Rgb8>* const picture =
      chain_.take(id, frame.video.after, frame.video.unit, side_by_side_size(eye));
  if (picture == nullptr) return;
  picture_ = Picture{two_eyes(*picture, eye), frame.request, frame.origin.requested_at};
}

const RequestRecord* VideoStream::received() const {
  return picture_ ? context_.link->receiver().find(picture_->request.frame) : nullptr;
}

std::optional<Duration> VideoStream::age(const FrameInputs& inputs) const {
  if (!picture_) return std::nullopt;
  return inputs.shown.display_time - picture_->requested_at;
}

class Remote final : public ModePipeline {
 public:
  explicit Remote(const RunContext& context) : context_(context), stream_(context, Answer::Video) {}

  void draw_ahead(const FrameInputs& inputs) override { static_cast<void>(draw(inputs)); }
  std::optional<FrameRequest> request(const FrameInputs& inputs) override { return stream_.request(inputs); }
  void collect(const FrameInputs& inputs) override { stream_.collect(inputs); }

  DrawnFrame draw(const FrameInputs& inputs) override {
    const VideoStream::Picture* const picture = stream_.picture();
    const StereoView& shown = inputs.shown.views;
    if (picture == nullptr) return draw_black(context_.renderer, shown);
    const StereoView& from = picture->request.views;
    context_.renderer.show_timewarped(picture->eyes, from, shown);
    return {.as = ShownAs::Picture,
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

  void draw_ahead(const FrameInputs& inputs) override {
    static_cast<void>(draw(inputs));
    const StereoView& views = inputs.shown.views;
    context_.renderer.draw_with_difference(
        {.views = views, .state = inputs.state, .masks = {}, .reprojection = {}},
        {Image<Rgb8>(views[0].size), Image<Rgb8>(views[1].size)}, views);
  }

  std::optional<FrameRequest> request(const FrameInputs& inputs) override { return stream_.request(inputs); }
  void collect(const FrameInputs& inputs) override { stream_.collect(inputs); }

  DrawnFrame draw(const FrameInputs& inputs) override {
    const ShownFrame frame{.views = inputs.shown.views,
                           .state = inputs.state,
                           .masks = {},
                           .reprojection = {},
                           .hidden = inputs.hidden};
    const VideoStream::Picture* const picture = stream_.picture();
    if (picture == nullptr) {
      context_.renderer.draw(frame);
      return {.as = ShownAs::Picture, .start_up = true};
    }
    const StereoView& from = picture->request.views;
    context_.renderer.draw_with_difference(frame, picture->eyes, from);
    return {.as = ShownAs::Picture,
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
