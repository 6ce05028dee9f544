#include "stereo/base/check.h"
#include "stereo/video/video.h"

namespace farshade {
namespace {

constexpr const char* kCure =
    "built without video: install libavcodec-dev, libavutil-dev and libswscale-dev (scripts/setup does) and "
    "configure with -DFARSHADE_VIDEO=ON";

}  // namespace

struct VideoEncoder::Codec {};
struct VideoDecoder::Codec {};

bool has_video() {
  return false;
}
std::string video_version() {
  return kCure;
}

VideoEncoder::VideoEncoder(std::unique_ptr<Codec> codec) : codec_(std::move(codec)) {}
VideoEncoder::VideoEncoder(VideoEncoder&&) noexcept = default;
VideoEncoder& VideoEncoder::operator=(VideoEncoder&&) noexcept = default;
VideoEncoder::~VideoEncoder() = default;
Expected<VideoEncoder> VideoEncoder::create(const VideoFormat&) {
  return fail(Fault::Unavailable, std::string("cannot encode video: ") + kCure);
}
const VideoFormat& VideoEncoder::format() const {
  check_failed("no encoder is made without video", "", CallPlace::current());
}
std::span<const std::byte> VideoEncoder::encode(const Image<Rgb8>&, KeyFrame) {
  check_failed("no encoder is made without video", "", CallPlace::current());
}

VideoDecoder::VideoDecoder(std::unique_ptr<Codec> codec) : codec_(std::move(codec)) {}
VideoDecoder::VideoDecoder(VideoDecoder&&) noexcept = default;
VideoDecoder& VideoDecoder::operator=(VideoDecoder&&) noexcept = default;
VideoDecoder::~VideoDecoder() = default;
Expected<VideoDecoder> VideoDecoder::create() {
  return fail(Fault::Unavailable, std::string("cannot decode video: ") + kCure);
}
Expected<const Image<Rgb8>*> VideoDecoder::decode(std::span<const std::byte>, Extent) {
  check_failed("no decoder is made without video", "", CallPlace::current());
}
bool VideoDecoder::concealed() const {
  check_failed("no decoder is made without video", "", CallPlace::current());
}
void VideoDecoder::reset() {}

}  // namespace farshade
