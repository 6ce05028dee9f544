/// CaptureLink: replays the messages of a capture. Each message arrives in the same frame as in the captured
/// run, and before or after the request as it did then. The link compares the requests of the replay with the
/// captured ones. It never waits.
#pragma once

#include "vr_client/link/answer_link.h"
#include "vr_client/record/capture_file.h"

namespace farshade {

class CaptureLink final : public AnswerLink {
 public:
  explicit CaptureLink(const CaptureHeader& header) : inbox_(header.requests, MaskLayout{header.lights}) {}

  /// Begins a frame. `frame` must live until the next call.
  void begin(const CapturedFrame& frame);

  /// Ends the current frame. Returns how its request differs from the captured one; nothing if they are
  /// equal.
  [[nodiscard]] std::optional<std::string> end();

  /// As with a NetworkLink, no request is sent before the first Welcome. The frame that received the Welcome
  /// may or may not have sent one.
  void request(const FrameRequest& request, Time asked_at,
               std::span<const std::vector<std::byte>> positions = {}) override;

  /// Takes all messages of the current frame, whatever the timeout.
  bool wait_for(FrameId frame, Duration timeout) override;

  [[nodiscard]] const AnswerInbox& inbox() const override { return inbox_; }
  [[nodiscard]] const std::optional<Error>& refused() const override { return refused_; }
  [[nodiscard]] Duration busy() const override { return busy_; }

 private:
  void take(std::span<const CapturedMessage> messages);

  AnswerInbox inbox_;
  bool welcomed_ = false;      ///< a Welcome was received
  bool was_welcomed_ = false;  ///< as welcomed_, when the current frame began
  const CapturedFrame* frame_ = nullptr;
  std::size_t taken_ = 0;   ///< messages of frame_->after
  bool requested_ = false;  ///< in the current frame
  std::optional<std::string> difference_;
  std::optional<Error> refused_;  ///< always empty
  Duration busy_{};
};

/// The first difference between a request and the captured one; nothing if they are equal.
[[nodiscard]] std::optional<std::string> difference_of(const FrameRequest& request,
                                                       const FrameRequest& captured);

}  // namespace farshade
