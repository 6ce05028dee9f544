/// Masks in hand: what hybrid and client-positions do alike - of what has come, the masks; drawn with them.
#pragma once

#include "vr_client/modes/exchange.h"

namespace farshade {

class MasksInHand {
 public:
  explicit MasksInHand(const Session& session) : session_(session) {}

  void take(std::span<const ReceivedFrame* const> received);

  /// Whose masks these are, newest first; at most as many as are drawn with.
  [[nodiscard]] std::vector<FrameId> frames() const;

  /// The G-buffer and the masks carried over to it; the depth of `asked`, if any, is kept for its masks.
  /// Masks that were made for these very pixels are not carried.
  Seen draw(const Moment& moment, const TraceRequest* asked, const Exchange& exchange);

 private:
  [[nodiscard]] bool is_exact(const MaskInHand& mask, const TraceRequest& shown) const;

  const Session& session_;
  std::vector<MaskInHand> masks_, drawn_with_;
  const ReceivedFrame* newest_ = nullptr;
};

}  // namespace farshade
