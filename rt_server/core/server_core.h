/// The server without its threads and its socket: datagrams come in by receive() and leave by send_due(),
/// requests are traced and packed by work(). A program calls them from two threads (serve.h); a test or a
/// study calls them in turn over a virtual link.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>

#include "rt_server/core/sessions.h"
#include "stereo/net/frame_packer.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

/// Traces a request into a frame whose buffers are reused: Tracer::trace, or what a test puts in its place.
using TraceFunction = std::function<TraceStats(const FrameRequest&, ShadowFrame&)>;

/// What an answer took besides packing.
struct AnswerCost {
  TraceStats traced{};
  Duration draw{}, coding{};
};
/// Gives the answers that are not masks of what the views see: adds its messages to the packer.
using AnswerFunction = std::function<AnswerCost(const Job&, FramePacker&)>;

struct ServerCounters {
  SessionCounters sessions;
  GateCounters gate;
  RefusalCounts refused;  ///< datagrams that are no message, or none of a session's
  PortCounters port;
  std::uint64_t frames = 0;       ///< traced
  std::size_t sessions_open = 0;  ///< now
  TraceStats traced;              ///< over all frames
};

/// `counters` in one line for a person at a terminal; of the reasons for refusals only those that occurred.
[[nodiscard]] std::string counters_line(const ServerCounters& counters);

/// What was traced and what needed no ray, in one line.
[[nodiscard]] std::string rays_line(const TraceStats& traced);

/// One thread may call receive(), send_due() and next_due() while another calls wait_for_work() and work();
/// counters() from any.
class ServerCore {
 public:
  /// `served` is what clients with the same scene are told; `ring` who may come. `port` and `clock` outlive
  /// the core. `others` gives what `served` offers besides masks.
  ServerCore(const Welcome& served, const std::vector<SharedKey>& ring, TraceFunction trace,
             DatagramPort& port, const Clock& clock, const SessionLimits& limits = {},
             SameAllOver same = SameAllOver::OneValue, AnswerFunction others = {});

  /// Takes the next datagram, waiting at most `wait` for it, and answers what needs no tracing. False: none
  /// came.
  bool receive(Duration wait);

  /// Sends what may leave by now.
  void send_due();

  /// When send_due() or work() next has something to do if nothing comes.
  [[nodiscard]] std::optional<Time> next_due() const;
  /// The same of send_due() alone.
  [[nodiscard]] std::optional<Time> next_send() const;

  /// Traces the newest request of the client whose turn it is; its slices are due from now on. False: nobody
  /// waits.
  bool work();

  /// Blocks until somebody may be served; false when `stop` was requested.
  bool wait_for_work(const std::stop_token& stop);

  /// Ends the receive() that waits now, or the next.
  void wake() { port_.wake(); }

  [[nodiscard]] ServerCounters counters() const;
  [[nodiscard]] const Clock& clock() const { return clock_; }

 private:
  AnswerCost answer(const Job& job);

  TraceFunction trace_;
  AnswerFunction others_;
  DatagramPort& port_;
  const Clock& clock_;

  mutable std::mutex mutex_;  ///< guards sessions_, refused_ and traced_
  std::condition_variable_any somebody_waits_;
  Sessions sessions_;
  RefusalCounts refused_;
  TraceStats traced_;

  // The network side's own.
  std::vector<std::byte> datagram_;

  // The working side's own.
  ShadowFrame frame_;
  FramePacker packer_;
  std::atomic<std::uint64_t> frames_ = 0;
};

}  // namespace farshade
