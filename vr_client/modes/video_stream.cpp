#include "vr_client/modes/video_stream.h"

#include <stdexcept>

namespace farshade {
namespace {

VideoDecoder make_decoder() {
  Expected<VideoDecoder> decoder = VideoDecoder::create();
  if (!decoder) throw std::runtime_error(decoder.error().what);
  return std::move(*decoder);
}

}  // namespace

VideoStream::VideoStream(const Session& session, Answer answer)
    : session_(session), answer_(answer), exchange_(session), decoder_(make_decoder()) {}

const TraceRequest* VideoStream::request(const Moment& moment) {
  const Duration interval = moment.period * moment.steering.wish.every;
  const TraceRequest* const asked =
      exchange_.plan(moment, {.answer = answer_,
                              .bits_per_second = session_.mode.bits_per_second,
                              .interval = interval,
                              .coding = decoded_ ? Coding::AfterLast : Coding::Alone});
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

/// A unit that was coded after another than the one decoded last is of no use: something in between is lost,
/// and from now on a picture is asked for that was coded alone.
void VideoStream::decode(const ReceivedFrame& frame) {
  const FrameId id = frame.request.frame, after = frame.video.after;
  if (after != id && after != decoded_) {
    decoded_.reset();
    return;
  }
  const Expected<const Image<Rgb8>*> decoded = decoder_.decode(frame.video.unit);
  const Extent eye = frame.request.views[0].size;
  if (!decoded || (*decoded)->size != side_by_side_size(eye)) {
    decoded_.reset();
    decoder_.reset();
    return;
  }
  decoded_ = id;
  picture_ = Picture{two_eyes(**decoded, eye), frame.request,
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
