#include "stereo/video/video.h"

namespace farshade {
namespace {

constexpr const char* kCure =
    "built without video: install libavcodec-dev, libavutil-dev and libswscale-dev (scripts/setup does) and "
    "configure with -DFARSHADE_VIDEO=ON";

}  // namespace

bool has_video() {
  return false;
}
std::string video_version() {
  return kCure;
}

Expected<std::unique_ptr<VideoEncoder>> VideoEncoder::create(const VideoFormat&) {
  return fail(Fault::Unavailable, std::string("cannot encode video: ") + kCure);
}
Expected<std::unique_ptr<VideoDecoder>> VideoDecoder::create() {
  return fail(Fault::Unavailable, std::string("cannot decode video: ") + kCure);
}

}  // namespace farshade
