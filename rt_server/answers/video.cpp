// Video and difference as H.264: the pictures of both eyes, or the difference that shadows make in them, with
// mid-grey for no difference.
#include "rt_server/answers/video.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "rt_server/answers/answer_renderer.h"
#include "stereo/image/difference_picture.h"

namespace farshade {
namespace {

/// A slice and the NAL units before it (parameter sets, refresh information) fit into one datagram.
constexpr std::uint32_t kSlice_bytes = kVideoPart_bytes - 64;

}  // namespace

Streams::Stream& Streams::stream_for(const Job& job, const VideoFormat& format) {
  Stream* const found = streams_.find(job.session.value);
  if (found != nullptr && found->encoder->format() == format) return *found;
  rebuilds_.take(job.key, job.arrived);
  const std::size_t bytes = kEncoder_bytes + format.size.pixels() * kPixel_bytes;
  streams_.make_room(job.session.value, job.key, bytes);
  Expected<std::unique_ptr<VideoEncoder>> encoder = VideoEncoder::create(format);
  if (!encoder) throw std::runtime_error(encoder.error().what);
  // The first picture of a stream is a key frame, so it depends on no other frame.
  return streams_.put(job.session.value, job.key, bytes, {std::move(*encoder), job.request.frame});
}

Duration Streams::code(const Job& job, const PerEye<Image<Rgb8>>& eyes, FramePacker& packer) {
  const Stopwatch coding;
  const FrameRequest& request = job.request;
  const Image<Rgb8> picture = side_by_side(eyes);
  const double rate = std::clamp(1.0 / seconds_of(request.answer.interval), 1.0, 1000.0);
  Stream& stream = stream_for(job, {.size = picture.size,
                                    .bits_per_second = request.answer.bits_per_second,
                                    .frames_per_second = rate,
                                    .slice_bytes = kSlice_bytes});
  // Frames between two pictures of a stream may be of other kinds, so numbers can go round meanwhile: a
  // picture that is not newer than the last one cannot be said to depend on it.
  const bool alone = request.answer.coding == Coding::Alone || !is_newer(request.frame, stream.last);
  const auto unit = stream.encoder->encode(picture, alone ? KeyFrame::Now : KeyFrame::IfNeeded);
  const VideoUnitParts parts = video_parts(unit);
  // The next picture depends on this one even if this one is too large to send.
  const FrameId last = std::exchange(stream.last, request.frame);
  if (parts.size() > kMostVideoParts) throw AnswerTooLarge(unit.size());
  packer.add(request.frame, alone ? request.frame : last, parts);
  return coding.elapsed();
}

namespace {

using Eyes = PerEye<Image<Rgb8>>;

Eyes with_shadows(const AnswerRenderer::RenderedAnswer& drawn) {
  return drawn.renderer.read_shown();
}

Eyes shadow_difference(const AnswerRenderer::RenderedAnswer& drawn) {
  Eyes eyes = drawn.renderer.read_shown();
  ShownFrame without = drawn.shown;
  without.masks = {};
  drawn.renderer.shade_again(without);
  const Eyes lit = drawn.renderer.read_shown();
  drawn.renderer.discard_times();  // its time is not that of the next picture
  for (std::size_t eye = 0; eye < kEyes; ++eye) eyes[eye] = difference_of(eyes[eye], lit[eye]);
  return eyes;
}

class CodedAnswer final : public RequestHandler {
 public:
  CodedAnswer(std::shared_ptr<AnswerRenderer> renderer,
              Eyes (*picture)(const AnswerRenderer::RenderedAnswer&))
      : renderer_(std::move(renderer)), picture_(picture) {}

  AnswerCost answer(const Job& job, FramePacker& packer) override {
    const AnswerRenderer::RenderedAnswer drawn = renderer_->draw(job);
    AnswerCost cost = drawn.cost;
    go_on_with(job);
    const Stopwatch drawing;
    const Eyes eyes = picture_(drawn);
    cost.draw += drawing.elapsed();
    go_on_with(job);
    cost.coding = streams_.code(job, eyes, packer);
    return cost;
  }

 private:
  std::shared_ptr<AnswerRenderer> renderer_;
  Eyes (*picture_)(const AnswerRenderer::RenderedAnswer&);
  Streams streams_{renderer_->memory().in_work() / 8};
};

}  // namespace

std::unique_ptr<RequestHandler> make_video(std::shared_ptr<AnswerRenderer> renderer) {
  return std::make_unique<CodedAnswer>(std::move(renderer), with_shadows);
}

std::unique_ptr<RequestHandler> make_difference(std::shared_ptr<AnswerRenderer> renderer) {
  return std::make_unique<CodedAnswer>(std::move(renderer), shadow_difference);
}

}  // namespace farshade
