/// The server without its threads and its socket: requests come in by receive(), the newest of them is
/// traced, packed and sent by work(). A program calls the two from two threads (serve.h); a test or a study
/// calls them in turn over a virtual link.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>

#include "rt_server/sessions.h"
#include "stereo/net/frame_packer.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

/// Traces a request into a frame whose buffers are reused: Tracer::trace, or what a test puts in its place.
using TraceFunction = std::function<TraceStats(const TraceRequest&, ShadowFrame&)>;

struct ServerCounters {
  SessionCounters sessions;
  RefusalCounts refused;  ///< datagrams that are no message
  PortCounters port;
  std::uint64_t frames = 0;  ///< traced and sent
};

/// All of `counters` that a person at a terminal cares for, in one line.
[[nodiscard]] std::string closing_line(const ServerCounters& counters);

/// One thread may call receive() while another calls wait_for_work() and work(); counters() from any.
class ServerCore {
 public:
  /// `served` is what clients with the same scene are told. `port` and `clock` outlive the core.
  ServerCore(const Welcome& served, TraceFunction trace, DatagramPort& port, const Clock& clock,
             SessionLimits limits = {});

  /// Takes the next datagram, waiting at most `wait` for it, and answers what needs no tracing.
  /// False: none came.
  bool receive(Duration wait);

  /// Serves the newest request of the client whose turn it is. False: nobody waits.
  bool work();

  /// Blocks until somebody waits; false when `stop` was requested.
  bool wait_for_work(const std::stop_token& stop);

  /// Ends the receive() that waits now, or the next.
  void wake() { port_.wake(); }

  [[nodiscard]] ServerCounters counters() const;

 private:
  void log_answer(const Peer& client, const ClientMessage& message, const ServerMessage& answer);

  TraceFunction trace_;
  DatagramPort& port_;
  const Clock& clock_;

  mutable std::mutex mutex_;  ///< guards sessions_ and refused_
  std::condition_variable_any somebody_waits_;
  Sessions sessions_;
  RefusalCounts refused_;

  // The receiving side's own.
  std::vector<std::byte> answer_bytes_;
  std::optional<std::pair<Peer, std::optional<RefusalReason>>> last_logged_;

  // The working side's own.
  ShadowFrame frame_;
  FramePacker packer_;
  std::atomic<std::uint64_t> frames_ = 0;
};

}  // namespace farshade
