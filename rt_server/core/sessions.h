/// Sessions: who is in, and whose request is traced next. A value without sockets, threads or clocks.
///
/// Of each client only the newest request waits; what it replaces is counted, never queued. The client for
/// which least work was done comes first, of equals the one that was served longest ago. Memory is bounded:
/// so many sessions, each of bounded size.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rt_server/core/gate.h"
#include "rt_server/core/session.h"

namespace farshade {

struct SessionLimits {
  std::size_t sessions = 64;
  double handshakes_per_second = 100;
  double bytes_per_second = 12.5e6;                ///< to one client
  Duration silence = std::chrono::seconds(10);     ///< a client that says nothing for so long is forgotten
  Duration unconfirmed = std::chrono::seconds(5);  ///< the same before it has said anything sealed
};

struct SessionCounters {
  std::uint64_t welcomed = 0;    ///< sessions begun
  std::uint64_t repeated = 0;    ///< hellos of sessions that were there
  std::uint64_t forgotten = 0;   ///< sessions ended by silence
  std::uint64_t replaced = 0;    ///< sessions ended by a newer one of the same key from the same address
  std::uint64_t moved = 0;       ///< changes of a client's address
  std::uint64_t requests = 0;    ///< from clients in session
  std::uint64_t superseded = 0;  ///< of these, replaced by a newer one before their turn
  std::uint64_t outdated = 0;    ///< of these, not newer than one that came before
  std::uint64_t too_large = 0;   ///< of these, for more pixels than may be asked for
  std::uint64_t unanswered = 0;  ///< of these, for what this server does not give
  std::uint64_t stray = 0;       ///< messages with positions of no request that waits
  std::uint64_t scene_mismatch = 0, busy = 0;  ///< proved hellos that were refused
  std::uint64_t held_back = 0;                 ///< frames that the limit of bytes a second slowed
  friend bool operator==(const SessionCounters&, const SessionCounters&) = default;
};

class Sessions {
 public:
  /// `served` is what a client with the same scene is told; `ring` who may come.
  Sessions(const Welcome& served, const std::vector<SharedKey>& ring, const SessionLimits& limits = {});

  /// Takes one datagram from `from`. `answer` becomes what to send back there at once, never longer than
  /// `datagram`, or is left empty.
  Decoded<void> handle(const Peer& from, std::span<const std::byte> datagram, Time now,
                       std::vector<std::byte>& answer);

  /// The newest request of the client whose turn it is; it waits no more.
  std::optional<Job> next_job(Time now);

  /// The messages of the frame that answers a job, and the work that it took. A session that has ended
  /// meanwhile gets nothing.
  void put(SessionId session, std::span<const std::vector<std::byte>> messages, Duration work, Time now);

  /// Seals the next datagram that is due; false: none is.
  bool seal_due(Time now, Peer& to, std::vector<std::byte>& datagram);

  /// When next_job or seal_due next has something to do, if nothing comes; the past if they have now.
  [[nodiscard]] std::optional<Time> job_at() const;
  [[nodiscard]] std::optional<Time> due_at() const;

  [[nodiscard]] std::size_t size() const { return sessions_.size(); }
  [[nodiscard]] const SessionCounters& counters() const { return counters_; }
  [[nodiscard]] const GateCounters& gate() const { return gate_.counters(); }

  /// What has happened since the last call, for the log: who came, and which proved client was refused why.
  struct Event {
    std::string name;
    Peer client;
    std::optional<RefusalReason> refused{};
  };
  std::optional<Event> take_event() { return std::exchange(event_, std::nullopt); }

 private:
  void greet(const Peer& from, const Hello& hello, std::span<const std::byte> datagram, Time now,
             std::vector<std::byte>& answer);
  Decoded<void> take(const Peer& from, const Sealed& sealed, std::span<const std::byte> datagram, Time now,
                     std::vector<std::byte>& answer);
  void end_earlier(SessionId kept);
  void forget_silent(Time now);
  [[nodiscard]] ClientSession* find(SessionId id);

  Welcome served_;
  SessionLimits limits_;
  Gate gate_;
  std::vector<ClientSession> sessions_;
  std::uint64_t jobs_ = 0;
  Duration work_{};  ///< at which the client stood whose turn came last: who was away begins there
  SessionCounters counters_;
  std::optional<Event> event_;
};

}  // namespace farshade
