/// Timeline: the stages of client and server on one time axis, written as trace events. The axis is the
/// client's clock, from the first frame on. The server's clock is unknown: place_work estimates when the
/// server worked on a request.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "vr_client/frame/frame_loop.h"

namespace farshade {

struct TimeSpan {
  Time begin, end;
};

/// Estimates when a server did `work` for a request that was sent at `sent` and whose first answer arrived at
/// `first`: in the middle of that interval, which assumes that both directions take equally long (F.
/// Cristian, "Probabilistic clock synchronization", Distributed Computing 3, 1989). The error is half of the
/// difference between the two directions, and at most half of the interval without the work. For example,
/// --net delays only the way to the client, so the work is shown late by half of that delay. Work that is
/// longer than the interval is shortened to it.
[[nodiscard]] TimeSpan place_work(Time sent, Time first, Duration work);

class Timeline {
 public:
  /// Adds a frame as soon as it was shown, in order. `receiver` is the frame receiver of the run's link, with
  /// times on the clock of `view.starts`; null without a server. If the server's report or slices of a
  /// request never arrive, the timeline shows no work of the server for it. Needs about 250 bytes per frame.
  void add(const FrameView& view, const FrameReceiver* receiver);

  /// The JSON text, about 2 KB per frame. Process 1 is vr_client, with the threads `frame` (request, collect
  /// with its wait, draw), `device` (G-buffer, depth, shade: their lengths are measured, and they are placed
  /// one after the other up to the end of draw) and `network` (datagrams, from the first slice of an answer
  /// to its report). Process 2 is rt_server, with the threads `waiting` (a request that waits for the tracer)
  /// and `worker` (work: primary, shadow, draw, pack, one after the other). A span that was measured by
  /// another clock is scaled down to fit into the span that contains it. Every event names its frame; events
  /// of the server name the frame of the request. Arrows lead from a request to its work, and from its
  /// packing to the first frame that was drawn with its masks as the newest. Spans that would overlap on a
  /// thread go to another thread of the same name.
  [[nodiscard]] std::string text() const;

  /// Writes text() to a file, whose folder must exist. Does nothing if `path` is empty.
  [[nodiscard]] Expected<void> write(const std::filesystem::path& path) const;

 private:
  struct ShownFrame {
    FrameId frame;
    StageStarts starts;
    DrawTimes drawn;
    std::optional<FinishedPicture> finished;
  };
  /// When a request was sent, and when the first slice and the report of its answer arrived.
  struct Exchange {
    FrameId frame;
    Time sent;
    std::optional<Time> first, last;
  };
  struct ServerRequest {
    Exchange exchange;
    std::optional<FrameReport> report{};
    std::optional<Time> drawn{};  ///< when the first frame with its masks as the newest began to be drawn
  };

  std::vector<ShownFrame> frames_;
  std::vector<ServerRequest> requests_;  ///< oldest first
  std::size_t settled_ = 0;              ///< number of requests, from the first on, that are complete
};

}  // namespace farshade
