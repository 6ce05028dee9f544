/// Video chain: decodes coded pictures that depend on the picture before. After a loss it goes on: the
/// picture has errors then, until the intra refresh has passed over it (stereo/video/video.h).
#pragma once

#include <optional>
#include <span>

#include "stereo/frame/answer_spec.h"
#include "stereo/frame/frame_id.h"
#include "stereo/video/video.h"

namespace farshade {

class VideoChain {
 public:
  /// Throws if the build has no decoder.
  VideoChain();

  /// Decodes a unit that was coded after the picture of frame `after`; a key frame names itself. The unit may
  /// lack parts. The picture is valid until the next call. Null if the unit gives no picture of this size, or
  /// if no key frame of this size has been decoded. After that, all units up to the next key frame give null.
  const Image<Rgb8>* take(FrameId frame, FrameId after, std::span<const std::byte> unit, Extent size);

  /// How the next unit must be coded so that it can be decoded.
  [[nodiscard]] Coding next() const { return size_ ? Coding::AfterLast : Coding::Alone; }

 private:
  std::unique_ptr<VideoDecoder> decoder_;
  std::optional<Extent> size_;  ///< of the last picture; none if only a key frame can be decoded
};

}  // namespace farshade
