/// AnswerLink: what a run of the client needs of the source of its answers. There are two: the network
/// (network_link.h) and a capture file (record/replay.h).
#pragma once

#include "stereo/base/expected.h"
#include "vr_client/link/answer_inbox.h"

namespace farshade {

class AnswerLink {
 public:
  virtual ~AnswerLink() = default;

  /// Sends a request. `requested_at` is the display time of the frame that makes it. `positions` are the
  /// messages that follow it: the PlaneSlices that it announces. Without a session nothing is sent or
  /// recorded.
  virtual void request(const FrameRequest& request, Time requested_at,
                       std::span<const std::vector<std::byte>> positions = {}) = 0;

  /// Receives until all of the answer to `frame` has come or `patience` is over. True if all has come.
  virtual bool wait_for(FrameId frame, Duration patience) = 0;

  [[nodiscard]] virtual const AnswerInbox& inbox() const = 0;

  /// Why the server refuses this client for good; no value while it does not.
  [[nodiscard]] virtual const std::optional<Error>& refused() const = 0;

  /// The time spent so far on opening, decoding and assembling messages, without waits.
  [[nodiscard]] virtual Duration busy() const = 0;
};

}  // namespace farshade
