#include "rt_server/answers/video_streams.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace farshade {

Streams::Stream& Streams::stream_for(const Job& job, const VideoFormat& format) {
  Stream* const found = streams_.find(job.session.value);
  if (found != nullptr && found->encoder.format() == format) return *found;
  Expected<VideoEncoder> encoder = VideoEncoder::create(format);
  if (!encoder) throw std::runtime_error(encoder.error().what);
  // The first picture of a stream is a key frame, so it depends on no other frame.
  return streams_.put(job.session.value, {std::move(*encoder), job.request.frame});
}

Duration Streams::code(const Job& job, const PerEye<Image<Rgb8>>& eyes, FramePacker& packer) {
  const Stopwatch coding;
  const FrameRequest& request = job.request;
  const Image<Rgb8> picture = side_by_side(eyes);
  const double rate = std::clamp(1.0 / seconds_of(request.answer.interval), 1.0, 1000.0);
  Stream& stream = stream_for(
      job,
      {.size = picture.size, .bits_per_second = request.answer.bits_per_second, .frames_per_second = rate});
  const bool alone = request.answer.coding == Coding::Alone;
  const auto unit = stream.encoder.encode(picture, alone ? KeyFrame::Now : KeyFrame::IfNeeded);
  // The next picture depends on this one even if this one is too large to send.
  const FrameId last = std::exchange(stream.last, request.frame);
  if (unit.size() > kMostVideoParts * kVideoPart_bytes)
    throw std::runtime_error("an encoded picture of " + std::to_string(unit.size()) +
                             " bytes is too large to send");
  packer.add(request.frame, alone ? request.frame : last, unit);
  return coding.elapsed();
}

}  // namespace farshade
