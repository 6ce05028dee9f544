/// Video stream: what remote and delta do alike - ask for a coded picture, decode what has come in order,
/// notice what is lost.
#pragma once

#include "vr_client/modes/exchange.h"
#include "vr_client/modes/video_chain.h"

namespace farshade {

class VideoStream {
 public:
  /// `answer` is Video or Difference. Throws where the build has no decoder: open_client has refused it.
  VideoStream(const Session& session, Answer answer);

  const TraceRequest* request(const Moment& moment);

  /// Decodes all that a frame may use by now and has not been decoded.
  void collect(const Moment& moment);

  /// The newest picture, with what it was made for.
  struct Picture {
    PerEye<Image<Rgb8>> eyes;
    TraceRequest request;
    Time asked_at;
  };
  /// Null before the first.
  [[nodiscard]] const Picture* picture() const { return picture_ ? &*picture_ : nullptr; }

  /// What was received for the picture, if that is still remembered.
  [[nodiscard]] const ReceivedFrame* received() const;
  [[nodiscard]] std::optional<Duration> age(const Moment& moment) const;
  /// What decoding took in this frame.
  [[nodiscard]] Duration decoding() const { return decoding_; }

 private:
  void decode(const ReceivedFrame& frame);

  const Session& session_;
  Answer answer_;
  Exchange exchange_;
  VideoChain chain_;
  std::optional<Picture> picture_;
  Duration decoding_{};
};

}  // namespace farshade
