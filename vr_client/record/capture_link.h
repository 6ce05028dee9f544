/// CaptureLink: the link of a session on file. It hears what was heard, in the frame and on the side of the
/// request it was heard on, and compares what is asked with what was asked. It never waits.
#pragma once

#include "vr_client/link/answer_link.h"
#include "vr_client/record/capture_file.h"

namespace farshade {

class CaptureLink final : public AnswerLink {
 public:
  explicit CaptureLink(const CaptureHeader& header) : inbox_(header.requests, MaskLayout{header.lights}) {}

  /// A frame begins; `frame` stays until the next call.
  void begin(const CapturedFrame& frame);

  /// The frame at hand was shown. How what it asked differs from what was asked; nothing if it does not.
  [[nodiscard]] std::optional<std::string> end();

  /// As over the wire, nothing is asked before the first Welcome, nor perhaps in the frame that heard it.
  void request(const FrameRequest& request, Time asked_at,
               std::span<const std::vector<std::byte>> positions = {}) override;

  /// Takes what the frame at hand heard, however short the patience.
  bool wait_for(FrameId frame, Duration patience) override;

  [[nodiscard]] const AnswerInbox& inbox() const override { return inbox_; }
  [[nodiscard]] const std::optional<Error>& refused() const override { return refused_; }
  [[nodiscard]] Duration busy() const override { return busy_; }

 private:
  void take(std::span<const CapturedMessage> messages);

  AnswerInbox inbox_;
  bool welcomed_ = false, was_welcomed_ = false;  ///< so far; before the frame at hand
  const CapturedFrame* frame_ = nullptr;
  std::size_t taken_ = 0;  ///< of frame_->after
  bool asked_ = false;     ///< in the frame at hand
  std::optional<std::string> difference_;
  std::optional<Error> refused_;  ///< never
  Duration busy_{};
};

/// In what one request differs from the one that was recorded; nothing if it does not.
[[nodiscard]] std::optional<std::string> difference_of(const FrameRequest& request,
                                                       const FrameRequest& recorded);

}  // namespace farshade
