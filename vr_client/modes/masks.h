/// Masks in hand: what hybrid and client-positions do alike - of what has come, the masks; drawn with them.
#pragma once

#include "vr_client/modes/exchange.h"

namespace farshade {

class MasksInHand {
 public:
  explicit MasksInHand(const RunContext& context) : context_(context) {}

  void take(std::span<const ReceivedFrame* const> received);

  /// Whose masks these are, newest first; at most as many as are drawn with.
  [[nodiscard]] std::vector<FrameId> frames() const;

  /// The G-buffer and the masks carried over to it; the depth of `asked`, if any, is kept for its masks.
  /// Masks that were made for these very pixels are not carried.
  DrawnFrame draw(const FrameInputs& inputs, const FrameRequest* asked, const Exchange& exchange);

 private:
  [[nodiscard]] bool is_exact(const TracedMask& mask, const FrameRequest& shown) const;

  const RunContext& context_;
  std::vector<TracedMask> masks_, drawn_with_;
  const ReceivedFrame* newest_ = nullptr;
};

}  // namespace farshade
