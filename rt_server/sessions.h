/// Sessions: who may ask, and whose request is traced next. A value without sockets, threads or clocks.
///
/// Of each client only the newest request waits; what it replaces is counted, never queued. The client that
/// was served longest ago comes first. Memory is bounded: so many sessions, one request each.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "stereo/net/datagram.h"
#include "stereo/wire/messages.h"

namespace farshade {

struct SessionLimits {
  std::size_t sessions = 64;
  Duration silence = std::chrono::seconds(10);  ///< a client that says nothing for so long is forgotten
};

struct SessionCounters {
  std::uint64_t welcomed = 0;    ///< sessions begun
  std::uint64_t forgotten = 0;   ///< sessions ended by silence
  std::uint64_t requests = 0;    ///< from welcomed clients
  std::uint64_t superseded = 0;  ///< of these, replaced by a newer one before their turn
  std::uint64_t outdated = 0;    ///< of these, not newer than one that came before
  std::uint64_t version_mismatch = 0, scene_mismatch = 0, busy = 0, not_welcomed = 0;  ///< refusals sent
  friend bool operator==(const SessionCounters&, const SessionCounters&) = default;
};

/// A request whose turn has come.
struct Job {
  Peer client;
  TraceRequest request;
  Time arrived;
  std::uint32_t superseded = 0;  ///< of this client's requests, so far
};

class Sessions {
 public:
  /// `served` is what a client with the same scene is told.
  explicit Sessions(const Welcome& served, SessionLimits limits = {});

  /// The answer to `message`, if it needs one at once.
  std::optional<ServerMessage> handle(const Peer& client, const ClientMessage& message, Time now);

  /// The newest request of the client that was served longest ago; it waits no more.
  std::optional<Job> next_job();
  [[nodiscard]] bool has_job() const;

  [[nodiscard]] std::size_t size() const { return sessions_.size(); }
  [[nodiscard]] const SessionCounters& counters() const { return counters_; }

 private:
  struct Session {
    Peer client;
    Time heard{};
    std::uint64_t served = 0;  ///< turn at which it was served last, or came
    std::optional<FrameId> newest{};
    std::optional<Job> waiting{};
    std::uint32_t superseded = 0;
  };

  std::optional<ServerMessage> greet(const Peer& client, const Hello& hello, Time now);
  std::optional<ServerMessage> take(const Peer& client, const RequestMessage& message, Time now);
  [[nodiscard]] ServerMessage refuse_client(RefusalReason reason, std::uint64_t& counter);
  [[nodiscard]] Session* find(const Peer& client);
  void forget_silent(Time now);

  Welcome served_;
  SessionLimits limits_;
  std::vector<Session> sessions_;
  std::uint64_t turn_ = 0;
  SessionCounters counters_;
};

}  // namespace farshade
