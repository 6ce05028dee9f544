#include "vr_client/modes/video_stream.h"

namespace farshade {

VideoStream::VideoStream(const RunContext& context, Answer answer)
    : context_(context), answer_(answer), exchange_(context.link, context.policy, context.steering.wish) {}

const FrameRequest* VideoStream::request(const FrameInputs& inputs) {
  const Duration interval = inputs.period * inputs.steering.wish.every;
  const FrameRequest* const asked = exchange_.plan(inputs, {.kind = answer_,
                                                            .bits_per_second = context_.mode.bits_per_second,
                                                            .interval = interval,
                                                            .coding = chain_.next()});
  exchange_.send(inputs);
  return asked;
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
}

void VideoStream::decode(const RequestRecord& frame) {
  const FrameId id = frame.request.frame;
  const Extent eye = frame.request.views[0].size;
  const Image<Rgb8>* const picture =
      chain_.take(id, frame.video.after, frame.video.unit, side_by_side_size(eye));
  if (picture == nullptr) return;
  picture_ = Picture{two_eyes(*picture, eye), frame.request, frame.origin.asked_at};
}

const RequestRecord* VideoStream::received() const {
  return picture_ ? context_.link->inbox().find(picture_->request.frame) : nullptr;
}

std::optional<Duration> VideoStream::age(const FrameInputs& inputs) const {
  if (!picture_) return std::nullopt;
  return inputs.shown.display_time - picture_->asked_at;
}

}  // namespace farshade
