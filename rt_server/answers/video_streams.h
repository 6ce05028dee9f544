/// Streams: an encoder a session, and the picture that its next unit is coded after.
#pragma once

#include "rt_server/answers/recent.h"
#include "rt_server/core/session.h"
#include "stereo/net/frame_packer.h"
#include "stereo/video/video.h"

namespace farshade {

class Streams {
 public:
  /// Codes both eyes for `job`, after the session's last picture where the request allows it and nothing of
  /// the stream has changed. Adds the unit to `packer`, and returns what coding took. Throws where there is
  /// no encoder.
  Duration code(const Job& job, const PerEye<Image<Rgb8>>& eyes, FramePacker& packer);

 private:
  struct Stream {
    VideoEncoder encoder;
    FrameId last{};
  };
  Stream& stream_for(const Job& job, const VideoFormat& format);

  /// An encoder takes tens of megabytes; of more sessions than this with video, those that wait longest begin
  /// anew with a key frame.
  Recent<std::uint64_t, Stream> streams_{8};
};

}  // namespace farshade
