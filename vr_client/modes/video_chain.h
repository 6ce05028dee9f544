/// Video chain: units that stand on one another, decoded in an unbroken row or not at all. A unit onto
/// another picture than the one it was coded after would decode, and be wrong.
#pragma once

#include <optional>
#include <span>

#include "stereo/frame/answer_spec.h"
#include "stereo/frame/frame_id.h"
#include "stereo/video/video.h"

namespace farshade {

class VideoChain {
 public:
  /// Throws where the build has no decoder.
  VideoChain();

  /// The picture of `unit`, which is whole and was coded after the one of frame `after` (`frame` itself:
  /// alone), valid until the next call. Null where that is not the unit taken last, or where it is damaged or
  /// of another size; from then on, until a unit comes that was coded alone.
  const Image<Rgb8>* take(FrameId frame, FrameId after, std::span<const std::byte> unit, Extent size);

  /// How the next unit must be coded to be of use.
  [[nodiscard]] Coding next() const { return last_ ? Coding::AfterLast : Coding::Alone; }

 private:
  VideoDecoder decoder_;
  std::optional<FrameId> last_;  ///< of the unit taken last
};

}  // namespace farshade
