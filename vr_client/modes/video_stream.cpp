#include "vr_client/modes/video_stream.h"

namespace farshade {

VideoStream::VideoStream(const Session& session, Answer answer)
    : session_(session), answer_(answer), exchange_(session) {}

const TraceRequest* VideoStream::request(const Moment& moment) {
  const Duration interval = moment.period * moment.steering.wish.every;
  const TraceRequest* const asked = exchange_.plan(moment, {.answer = answer_,
                                                            .bits_per_second = session_.mode.bits_per_second,
                                                            .interval = interval,
                                                            .coding = chain_.next()});
  exchange_.send(moment);
  return asked;
}

void VideoStream::collect(const Moment& moment) {
  const auto received = exchange_.receive(moment);
  const Stopwatch watch;
  for (auto oldest_first = received.rbegin(); oldest_first != received.rend(); ++oldest_first) {
    const ReceivedFrame* const frame = *oldest_first;
    const bool is_news = !picture_ || is_newer(frame->request.frame, picture_->request.frame);
    if (is_news && frame->video.complete()) decode(*frame);
  }
  decoding_ = watch.elapsed();
}

void VideoStream::decode(const ReceivedFrame& frame) {
  const FrameId id = frame.request.frame;
  const Extent eye = frame.request.views[0].size;
  const Image<Rgb8>* const picture =
      chain_.take(id, frame.video.after, frame.video.unit, side_by_side_size(eye));
  if (picture == nullptr) return;
  picture_ = Picture{two_eyes(*picture, eye), frame.request,
                     session_.link->inbox().asked_at(id).value_or(frame.request.display_time)};
}

const ReceivedFrame* VideoStream::received() const {
  return picture_ ? session_.link->inbox().find(picture_->request.frame) : nullptr;
}

std::optional<Duration> VideoStream::age(const Moment& moment) const {
  if (!picture_) return std::nullopt;
  return moment.shown.display_time - picture_->asked_at;
}

}  // namespace farshade
