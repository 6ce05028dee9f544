/// Sessions: which clients are connected, and whose request is answered next. A value without sockets,
/// threads or clocks.
///
/// The server stores only the newest request of each client. It counts the requests that a newer one
/// replaced. The key on whose clients the least work was spent is served next (key_ledger.h), and of its
/// sessions the one on which the least was spent; among equals, the one that was served longest ago. A full
/// server takes a session from the key that has the most. Memory is bounded: the number of sessions and the
/// size of each are.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "rt_server/core/client_event.h"
#include "rt_server/core/gate.h"
#include "rt_server/core/key_ledger.h"
#include "rt_server/core/session.h"

namespace farshade {

struct SessionLimits {
  std::size_t sessions = 64;
  double handshakes_per_second = 100;
  double bytes_per_second = 12.5e6;            ///< to one client
  Duration silence = kSessionTimeout;          ///< timeout of a session
  Duration unconfirmed = kUnconfirmedTimeout;  ///< the same until its first sealed datagram has arrived
};

struct SessionCounters {
  std::uint64_t welcomed = 0;    ///< sessions begun
  std::uint64_t repeated = 0;    ///< hellos of sessions that exist
  std::uint64_t forgotten = 0;   ///< sessions ended by timeout
  std::uint64_t replaced = 0;    ///< sessions ended by a newer one of the same key from the same address
  std::uint64_t withdrawn = 0;   ///< sessions ended because the answer they use is no longer offered
  std::uint64_t revoked = 0;     ///< sessions ended because their key was taken out of the ring
  std::uint64_t displaced = 0;   ///< sessions ended for a client whose key had fewer
  std::uint64_t moved = 0;       ///< changes of a client's address
  std::uint64_t requests = 0;    ///< requests of all sessions; the next four count some of them
  std::uint64_t superseded = 0;  ///< replaced by a newer request before they were answered
  std::uint64_t outdated = 0;    ///< not newer than an earlier request
  std::uint64_t too_large = 0;   ///< for more pixels than allowed
  std::uint64_t unanswered = 0;  ///< for an answer that the server does not offer
  std::uint64_t stray = 0;       ///< parts of requests that belong to no waiting one
  std::uint64_t scene_mismatch = 0, busy = 0;  ///< hellos with a valid key that were refused
  std::uint64_t held_back = 0;                 ///< frames slowed by the limit of bytes per second
  std::uint64_t black_holes = 0;               ///< paths that stopped to carry large datagrams
  friend bool operator==(const SessionCounters&, const SessionCounters&) = default;
};

class Sessions {
 public:
  /// `served` goes to each client that has the same scene. Clients need a key of `ring`.
  Sessions(const Welcome& served, const std::vector<SharedKey>& ring, const SessionLimits& limits = {});

  /// Processes one datagram from `from`. `answer` becomes a datagram to send there at once, never longer than
  /// `datagram` if the address is not proved, or is left empty.
  Decoded<void> handle(const Peer& from, std::span<const std::byte> datagram, Time now,
                       std::vector<std::byte>& answer);

  /// Removes and returns the request to answer next, if one is ready.
  std::optional<Job> next_job(Time now);

  /// Queues the messages that answer a job, and counts the `work` that it took. Does nothing if the session
  /// has ended.
  void put(SessionId session, std::span<const std::vector<std::byte>> messages, Duration work, Time now);

  /// From now on offers only `answers`. Sessions that use another answer end: their clients are told so by
  /// NoSession, connect again and read in the Welcome what is offered.
  void offer(AnswerSet answers);

  /// From now on serves only clients with these keys. The sessions of other keys end.
  void set_ring(const std::vector<SharedKey>& ring);

  /// Seals the next datagram that is due, for `to`. Returns false if none is.
  bool seal_due(Time now, Peer& to, std::vector<std::byte>& datagram);

  /// When next_job() or seal_due() next has something to do if no datagram arrives. A time in the past means
  /// now.
  [[nodiscard]] std::optional<Time> job_at() const;
  [[nodiscard]] std::optional<Time> due_at() const;

  [[nodiscard]] std::size_t size() const { return sessions_.size(); }
  [[nodiscard]] const SessionCounters& counters() const { return counters_; }
  [[nodiscard]] const GateCounters& gate() const { return gate_.counters(); }

  /// Ends the sessions of clients that have been silent for too long. handle() does that, too.
  void end_silent(Time now);
  /// When end_silent() has to look at the sessions again if no datagram arrives: not after the first of them
  /// ends.
  [[nodiscard]] std::optional<Time> silent_at() const { return silent_at_; }

  /// Whether the last datagram given to handle() was opened by a session. Only then a request may have come.
  [[nodiscard]] bool was_opened() const { return was_opened_; }

  /// Removes and returns what happened since the last call, for the log: at most one event for each session
  /// and each datagram.
  std::vector<ClientEvent> take_events() { return std::exchange(events_, {}); }

 private:
  void handle_hello(const Peer& from, const Hello& hello, std::span<const std::byte> datagram, Time now,
                    std::vector<std::byte>& answer);
  Decoded<void> handle_sealed(const Peer& from, const Sealed& sealed, std::span<const std::byte> datagram,
                              Time now, std::vector<std::byte>& answer);
  void count(ReceivedMessage received);
  void end_replaced(SessionId kept);
  [[nodiscard]] Time end_of(const ClientSession& session) const;
  template <class IsOver>
  std::uint64_t end_sessions(ClientEvent::Kind why, const IsOver& is_over);
  [[nodiscard]] ClientSession* find(SessionId id);
  [[nodiscard]] const ClientSession* to_displace(const KeyId& newcomer) const;
  void end_displaced(SessionId id);

  Welcome served_;
  SessionLimits limits_;
  Gate gate_;
  std::vector<ClientSession> sessions_;
  // What a stranger's datagram needs, so that its cost does not grow with the number of sessions.
  std::unordered_map<std::uint64_t, std::size_t> place_of_;  ///< in sessions_, by SessionId
  std::optional<Time> silent_at_;
  mutable std::optional<std::optional<Time>> due_at_;  ///< no value: to be found anew
  bool was_opened_ = false;
  std::uint64_t jobs_ = 0;
  KeyLedger ledger_;
  Duration work_{};  ///< KeyAccount::work of the key served last: a new or idle key starts at this value
  /// The job that the worker has, and its key, which owes its work even if the session ends meanwhile.
  std::optional<std::pair<SessionId, KeyId>> in_work_;
  SessionCounters counters_;
  std::vector<ClientEvent> events_;
};

}  // namespace farshade
