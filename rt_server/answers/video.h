/// Streams: the video encoder of each session, and the frame that its next picture is coded after.
#pragma once

#include "rt_server/answers/fair_lru_cache.h"
#include "rt_server/answers/rebuilds.h"
#include "rt_server/sessions/job.h"
#include "stereo/answers/frame_packer.h"
#include "stereo/video/video.h"

namespace farshade {

class Streams {
 public:
  /// The encoders take `most_bytes` in all, or there is only one.
  explicit Streams(std::size_t most_bytes) : streams_(kStreams, most_bytes) {}

  /// Encodes both eyes for `job` and adds the unit to `packer`. The unit depends on the session's last
  /// picture if the request allows it and the format is unchanged. Returns the time that encoding took.
  /// Throws if no encoder can be opened or the unit is too large to send.
  Duration code(const Job& job, const PerEye<Image<Rgb8>>& eyes, FramePacker& packer);

 private:
  struct Stream {
    std::unique_ptr<VideoEncoder> encoder;
    FrameId last{};
  };
  Stream& stream_for(const Job& job, const VideoFormat& format);

  /// Beside the limit of their memory. A stream that is evicted starts again with a key frame.
  static constexpr std::size_t kStreams = 64;
  /// Memory of an encoder, and of a pixel of both eyes (answers_bench: together 2.1 MiB at 2 x 128x128).
  static constexpr std::size_t kEncoder_bytes = std::size_t{2} << 20, kPixel_bytes = 16;
  FairLruCache<std::uint64_t, Stream> streams_;
  Rebuilds rebuilds_;
};

}  // namespace farshade
