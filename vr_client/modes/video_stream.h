/// Video stream: the part that modes remote and delta share. It requests coded pictures, decodes them in
/// order and requests a key frame after a loss.
#pragma once

#include "vr_client/modes/exchange.h"
#include "vr_client/modes/video_chain.h"

namespace farshade {

class VideoStream {
 public:
  /// `answer` is Video or Difference. Throws if the build has no decoder, which open_client refuses before.
  VideoStream(const RunContext& context, Answer answer);

  const FrameRequest* request(const FrameInputs& inputs);

  /// Decodes the pictures that this frame may use and that have not been decoded yet.
  void collect(const FrameInputs& inputs);

  /// The newest picture and its request.
  struct Picture {
    PerEye<Image<Rgb8>> eyes;
    FrameRequest request;
    Time asked_at;
  };
  /// Null before the first picture.
  [[nodiscard]] const Picture* picture() const { return picture_ ? &*picture_ : nullptr; }

  /// The record of the picture's request; null if it is forgotten.
  [[nodiscard]] const RequestRecord* received() const;
  [[nodiscard]] std::optional<Duration> age(const FrameInputs& inputs) const;
  /// The time that decoding took in this frame.
  [[nodiscard]] Duration decoding() const { return decoding_; }

 private:
  void decode(const RequestRecord& frame);

  const RunContext& context_;
  Answer answer_;
  Exchange exchange_;
  VideoChain chain_;
  std::optional<Picture> picture_;
  Duration decoding_{};
};

}  // namespace farshade
