/// Video stream: what remote and delta do alike - ask for a coded picture, decode what has come in order,
/// notice what is lost.
#pragma once

#include "vr_client/modes/exchange.h"
#include "vr_client/modes/video_chain.h"

namespace farshade {

class VideoStream {
 public:
  /// `answer` is Video or Difference. Throws where the build has no decoder: open_client has refused it.
  VideoStream(const RunContext& context, Answer answer);

  const FrameRequest* request(const FrameInputs& inputs);

  /// Decodes all that a frame may use by now and has not been decoded.
  void collect(const FrameInputs& inputs);

  /// The newest picture, with what it was made for.
  struct Picture {
    PerEye<Image<Rgb8>> eyes;
    FrameRequest request;
    Time asked_at;
  };
  /// Null before the first.
  [[nodiscard]] const Picture* picture() const { return picture_ ? &*picture_ : nullptr; }

  /// What was received for the picture, if that is still remembered.
  [[nodiscard]] const ReceivedFrame* received() const;
  [[nodiscard]] std::optional<Duration> age(const FrameInputs& inputs) const;
  /// What decoding took in this frame.
  [[nodiscard]] Duration decoding() const { return decoding_; }

 private:
  void decode(const ReceivedFrame& frame);

  const RunContext& context_;
  Answer answer_;
  Exchange exchange_;
  VideoChain chain_;
  std::optional<Picture> picture_;
  Duration decoding_{};
};

}  // namespace farshade
