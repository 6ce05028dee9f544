/// AnswerLink: what a session needs of whoever brings it masks: the wire (shadow_link.h) or a session on file
/// (record/replay_link.h).
#pragma once

#include "stereo/base/expected.h"
#include "vr_client/link/answer_inbox.h"

namespace farshade {

class AnswerLink {
 public:
  virtual ~AnswerLink() = default;

  /// `asked_at` is the display time of the frame that asks; AnswerInbox::received tells frames apart by it.
  /// `positions` are messages that go behind the request: the PlaneSlices that it announces.
  virtual void request(const FrameRequest& request, Time asked_at,
                       std::span<const std::vector<std::byte>> positions = {}) = 0;

  /// Takes in what arrives until `frame` is whole or `patience` is over. True if it is whole.
  virtual bool wait_for(FrameId frame, Duration patience) = 0;

  [[nodiscard]] virtual const AnswerInbox& inbox() const = 0;

  /// A refusal that no waiting can cure.
  [[nodiscard]] virtual const std::optional<Error>& refused() const = 0;

  /// Time spent so far on opening, decoding and assembling, waits not counted.
  [[nodiscard]] virtual Duration busy() const = 0;
};

}  // namespace farshade
