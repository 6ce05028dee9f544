/// MaskStream: the part that all modes with a server share. It plans and sends the requests, waits for
/// answers where the policy says so, and tells which answers a frame may use.
#pragma once

#include "vr_client/frame/frame_loop.h"

namespace farshade {

/// In virtual time the client waits in real time for a frame's answer before it draws the frame, so that the
/// picture depends on the configured delay alone. An answer that takes longer than this counts as lost.
inline constexpr Duration kVirtualPatience = std::chrono::seconds(8);

/// In virtual time: waits in real time until the whole answer to `frame` has come, or nothing more of it for
/// a second, or `patience` is over. True if at least a part has come.
bool wait_until_idle(ServerConnection& link, FrameId frame, Duration patience);

/// The time since a request was made.
[[nodiscard]] inline Duration age_of(const RequestRecord& record, const FrameInputs& inputs) {
  return inputs.shown.display_time - record.origin.requested_at;
}

/// Shows black: the frames of a mode that shows pictures of the server, before the first one has come.
[[nodiscard]] DrawnFrame draw_black(Renderer& renderer, const StereoView& shown);

class MaskStream {
 public:
  /// `link` may be null: then there are no requests and no answers.
  MaskStream(ServerConnection* link, const MaskPolicy& policy, const RequestSettings& settings,
             SceneMotion motion = SceneMotion::Moving);

  /// Plans this frame's request for an answer of the kind `answer`. No value on frames without a request.
  /// Requests for pictures have the full size. A G-buffer has no guard band, because the renderer shades
  /// views of the shown size only.
  [[nodiscard]] std::optional<FrameRequest> plan(const FrameInputs& inputs, const AnswerSpec& answer);

  /// The time between the frame that asks and the frame that the request is made for.
  [[nodiscard]] Duration lead(Duration period) const { return plan_.lead(period); }

  /// Sends this frame's request as it was planned, or as the caller has completed it: what it asks for, and
  /// the number of messages that follow it.
  void send(const FrameInputs& inputs, const FrameRequest& request, const RequestParts& parts = {});

  /// Whether a request may ask for a part of its views.
  [[nodiscard]] bool takes_parts() const { return link_->takes_parts(); }

  /// The newest record that a frame may use now and that is as complete as it will be; null if there is none.
  /// Does not wait.
  [[nodiscard]] const RequestRecord* newest_settled(const FrameInputs& inputs);

  /// Waits for answers where the policy says so, then returns the answers that this frame may use, newest
  /// first. The pointers stay valid until the next request.
  std::span<const RequestRecord* const> receive(const FrameInputs& inputs);

  /// Of the answers last received, the newest that is as complete as it will be; before there is one, the
  /// newest. It is never older than that of an earlier frame. Null if there is no answer.
  [[nodiscard]] const RequestRecord* settled() const { return settled_; }

  /// The frame is drawn with the masks of `record` as its first source, or with its picture. The guard band
  /// learns from that.
  void drawn_with(const FrameInputs& inputs, const RequestRecord& record);

  /// The slot of the record that the planned request will get when it is sent.
  [[nodiscard]] std::size_t next_slot() const { return link_->receiver().next_slot(); }
  /// The record of a request; null if there is no request, it was not sent, or it is forgotten.
  [[nodiscard]] const RequestRecord* record(std::optional<FrameId> request) const;

 private:
  void wait_for_answer();
  void settle(const FrameInputs& inputs);
  [[nodiscard]] Time usable_until(Time display_time) const;

  ServerConnection* link_;
  MaskPolicy policy_;
  RequestPlan plan_;
  std::vector<const RequestRecord*> received_;
  const RequestRecord* settled_ = nullptr;
  FrameId newest_learned_;  ///< the newest frame whose latency is known; frames count from 1
  FrameId requested_, waited_for_;
  bool is_answering_ = true;
};

}  // namespace farshade
