/// Mask sources: the masks that modes hybrid and client-positions draw a frame with, in the order in which
/// the shader trusts them.
#pragma once

#include "vr_client/modes/cube_mask.h"
#include "vr_client/modes/mask_stream.h"

namespace farshade {

class MaskSources {
 public:
  /// `is_animated`: the scene has animations, so a mask is exact at one scene time only.
  explicit MaskSources(bool anything_moves) : anything_moves_(anything_moves) {}

  /// Chooses the masks of a frame: first the newest of `usable` that is as complete as it will be
  /// (`settled`, one of `usable` or null), then the others from new to old. So newer masks, of which a part
  /// has come, fill in what the first one does not know.
  void take(std::span<const RequestRecord* const> usable, const RequestRecord* settled);

  [[nodiscard]] std::span<const TracedMask> masks() const { return masks_; }

  /// Direct if the first mask was traced for exactly the pixels, scene time and lights of `shown` and is
  /// complete; otherwise `requested`.
  [[nodiscard]] Lookup lookup(const FrameMoment& shown, Lookup requested) const;

  /// Draws the G-buffer and shades it with the masks and those of the cube mask, which may be null. Keeps the
  /// depth of the views of `record`, the record of this frame's request, unless it is null.
  DrawnFrame draw(Renderer& renderer, const FrameInputs& inputs, const RequestRecord* record,
                  MaskStream& mask_stream, const CubeMask* cube_mask = nullptr);

 private:
  bool anything_moves_;
  std::vector<const RequestRecord*> records_;  ///< in the order of trust
  std::vector<TracedMask> masks_, drawn_with_;
};

}  // namespace farshade
