/// Timeline: the stages of client and server on one time axis, in the Trace Event Format (Google, "Trace
/// Event Format", 2016: the JSON object form), which Perfetto's UI and chrome://tracing open. All on the
/// client's clock from its first frame on. The server's clock is not ours: where its work lay between our
/// request and its first slice is an estimate, see place_work.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "vr_client/frame/frame_loop.h"

namespace farshade {

struct TimeSpan {
  Time begin, end;
};

/// Where `work` lay that a request sent at `sent` caused and whose first answer came at `first`: in the
/// middle of what it leaves, as the way there and the way back are taken to be equally long (F. Cristian,
/// "Probabilistic clock synchronization", Distributed Computing 3, 1989). Wrong by half of what the two ways
/// differ by, and never by more than half of what the work leaves: under --net, which impairs the way back
/// alone, the server's work is shown late by half of the delay. Work longer than the interval fills it.
[[nodiscard]] TimeSpan place_work(Time sent, Time first, Duration work);

class Timeline {
 public:
  /// Of a frame as soon as it was shown, in order. `inbox` is what the session's link fills, on the clock of
  /// `view.starts`; null where no server traces. A frame's exchange with the server is kept once, as soon as
  /// all of it is in hand; a server whose report or slices never came has no part in that frame.
  /// Keeps about 250 bytes a frame.
  void add(const FrameView& view, const AnswerInbox* inbox);

  /// JSON, about 2 KB a frame. Times are microseconds since the first frame's begin, to an eighth. Process 1
  /// is vr_client: threads `frame` (request, collect with its wait, draw), `device` (G-buffer, depth, shade:
  /// their lengths are measured, they are laid end to end to the end of draw) and `network` (datagrams, from
  /// an answer's first slice to its report). Process 2 is rt_server: threads `waiting` (a request, for its
  /// trace) and `worker` (work: primary, shadow, pack, laid end to end). Spans never leave those that hold
  /// them: what was measured longer by another clock is scaled down. Every event names its frame, a server's
  /// the frame that asked. Arrows lead from a request to its work and from its packing to the frame first
  /// drawn with its masks as the newest. Spans that would overlap in a row go to another of the same name.
  [[nodiscard]] std::string text() const;

  /// text() into a file; its folder must exist.
  [[nodiscard]] Expected<void> write(const std::filesystem::path& path) const;

 private:
  struct Shown {
    FrameId frame;
    StageStarts starts;
    Duration gbuffer{}, depth{}, shade{}, draw{};
  };
  /// When a request was sent, and when the first piece and the report of its answer came.
  struct Exchange {
    FrameId frame;
    Time sent;
    std::optional<Time> first, last;
  };
  struct Asked {
    Exchange exchange;
    std::optional<FrameReport> report{};
    std::optional<Time> drawn{};  ///< when the first frame began to be drawn with its masks as the newest
  };
  class Events;

  static void write_shown(const Shown& shown, Events& events);
  static void write_asked(const Asked& asked, Events& events);

  std::vector<Shown> shown_;
  std::vector<Asked> asked_;  ///< oldest first
  std::size_t settled_ = 0;   ///< of these, the first so many: nothing more will be learnt of their exchange
};

}  // namespace farshade
