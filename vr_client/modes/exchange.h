/// Exchange: what all modes with a server share - predict the views to ask for, send, await what may be
/// awaited, and tell what of all that has come a frame may use.
#pragma once

#include "vr_client/modes/way.h"

namespace farshade {

class Exchange {
 public:
  explicit Exchange(const Session& session);

  /// What this frame should ask for, to be answered as `wanted` says; null on frames that ask for nothing.
  /// Pictures are asked for in the shown size, without a guard band: they are turned, not looked up.
  const TraceRequest* plan(const Moment& moment, const Wanted& wanted);

  /// What was planned, now that so many positions' messages are to go behind it.
  const TraceRequest* complete(std::uint32_t slices);

  /// Sends what was planned. `positions` are messages that go behind it.
  void send(const Moment& moment, std::span<const std::vector<std::byte>> positions = {});

  /// Awaits what may be awaited, then gives what a frame may use of all that has come, newest first.
  std::span<const ReceivedFrame* const> receive(const Moment& moment);

  /// How long ago `frame` was asked for.
  [[nodiscard]] std::optional<Duration> age(const ReceivedFrame* frame, const Moment& moment) const;

 private:
  void await();
  bool await_what_comes(Duration patience);
  [[nodiscard]] bool is_whole(FrameId frame) const;
  [[nodiscard]] Time usable_until(Time display_time) const;

  const Session& session_;
  RequestPlan plan_;
  std::optional<TraceRequest> request_;
  std::vector<const ReceivedFrame*> received_;
  FrameId newest_seen_;  ///< frames count from 1
  FrameId asked_, awaited_;
  bool answering_ = true;
};

}  // namespace farshade
