/// Video chain: decodes coded pictures that depend on the picture before. A picture that is decoded after
/// another one than it was coded after would be wrong without an error, so the chain refuses it.
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

  /// Decodes a complete unit that was coded after the picture of frame `after`; a key frame names itself.
  /// The picture is valid until the next call. Null if `after` is not the frame decoded last, or if the unit
  /// is damaged or of another size. After that, all units up to the next key frame give null.
  const Image<Rgb8>* take(FrameId frame, FrameId after, std::span<const std::byte> unit, Extent size);

  /// How the next unit must be coded so that it can be decoded.
  [[nodiscard]] Coding next() const { return last_ ? Coding::AfterLast : Coding::Alone; }

 private:
  VideoDecoder decoder_;
  std::optional<FrameId> last_;  ///< the frame decoded last
};

}  // namespace farshade
