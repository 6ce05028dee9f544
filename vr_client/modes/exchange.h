/// Exchange: what all modes with a server share - predict the views to ask for, send, await what may be
/// awaited, and tell what of all that has come a frame may use.
#pragma once

#include "vr_client/frame/mode_pipeline.h"

namespace farshade {

class Exchange {
 public:
  explicit Exchange(const RunContext& context);

  /// What this frame should ask for, to be answered as `wanted` says; null on frames that ask for nothing.
  /// Pictures are asked for in the shown size, without a guard band: they are turned, not looked up.
  const FrameRequest* plan(const FrameInputs& inputs, const AnswerSpec& wanted);

  /// What was planned, now that so many positions' messages are to go behind it.
  const FrameRequest* complete(std::uint32_t slices);

  /// Sends what was planned. `positions` are messages that go behind it.
  void send(const FrameInputs& inputs, std::span<const std::vector<std::byte>> positions = {});

  /// Awaits what may be awaited, then gives what a frame may use of all that has come, newest first.
  std::span<const ReceivedFrame* const> receive(const FrameInputs& inputs);

  /// How long ago `frame` was asked for.
  [[nodiscard]] std::optional<Duration> age(const ReceivedFrame* frame, const FrameInputs& inputs) const;

 private:
  void await();
  bool await_what_comes(Duration patience);
  [[nodiscard]] bool is_whole(FrameId frame) const;
  [[nodiscard]] Time usable_until(Time display_time) const;

  const RunContext& context_;
  RequestPlan plan_;
  std::optional<FrameRequest> request_;
  std::vector<const ReceivedFrame*> received_;
  FrameId newest_seen_;  ///< frames count from 1
  FrameId asked_, awaited_;
  bool answering_ = true;
};

}  // namespace farshade
