/// Sessions: which clients are connected, and whose request is answered next. A value without sockets,
/// threads or clocks.
///
/// The server stores only the newest request of each client. It counts the requests that a newer one
/// replaced. The key on whose clients the least work was spent is served next (rt_server/scheduling/turns.h),
/// and of its sessions the one on which the least was spent; among equals, the one that was served longest
/// ago. A full server takes a session from the key that has the most. Memory is bounded: the number of
/// sessions and the size of each are.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "rt_server/admission/gate.h"
#include "rt_server/admission/key_ledger.h"
#include "rt_server/admission/memory_share.h"
#include "rt_server/log/client_event.h"
#include "rt_server/scheduling/turns.h"
#include "rt_server/sessions/session.h"

namespace farshade {

struct SessionLimits {
  std::size_t sessions = 64;
  double handshakes_per_second = 100;
  double bytes_per_second = 12.5e6;            ///< to one client
  double total_bytes_per_second = 125e6;       ///< of answers to all clients together
  MemoryShare memory{};                        ///< that clients may make the server hold
  Duration silence = kSessionTimeout;          ///< timeout of a session
  Duration unconfirmed = kUnconfirmedTimeout;  ///< the same until its first sealed datagram has arrived
};

struct SessionCounters {
  std::uint64_t welcomed = 0;       ///< sessions begun
  std::uint64_t repeated = 0;       ///< hellos of sessions that exist
  std::uint64_t forgotten = 0;      ///< sessions ended by timeout
  std::uint64_t left = 0;           ///< sessions ended by their clients
  std::uint64_t replaced = 0;       ///< sessions ended by a newer one of the same key from the same address
  std::uint64_t withdrawn = 0;      ///< sessions ended because the answer they use is no longer offered
  std::uint64_t revoked = 0;        ///< sessions ended because their key was taken out of the ring
  std::uint64_t expired = 0;        ///< sessions ended because their key's time was over
  std::uint64_t displaced = 0;      ///< sessions ended for a client whose key had fewer
  std::uint64_t moved = 0;          ///< changes of a client's address
  std::uint64_t false_reports = 0;  ///< sessions that reported the arrival of what was never sent
  std::uint64_t requests = 0;       ///< requests of all sessions; the next four count some of them
  std::uint64_t superseded = 0;     ///< replaced by a newer request before they were answered
  std::uint64_t outdated = 0;       ///< not newer than an earlier request
  std::uint64_t too_large = 0;      ///< for more pixels than allowed
  std::uint64_t unanswered = 0;     ///< for an answer that the server does not offer
  std::uint64_t stray = 0;          ///< parts of requests that belong to no waiting one
  std::uint64_t over_memory = 0;    ///< sessions, parts and answers refused for the limit of memory
  std::uint64_t too_costly = 0;     ///< answered without content, because the answer would take too long
  std::uint64_t scene_mismatch = 0, busy = 0;  ///< hellos with a valid key that were refused
  std::uint64_t ignored = 0;                   ///< hellos with a valid key while nobody new is admitted
  std::uint64_t key_full = 0;                  ///< the same: their key has as many sessions as it may
  std::uint64_t held_back = 0;                 ///< frames slowed by the limit of bytes per second
  std::uint64_t overtaken = 0;                 ///< frames whose rest a newer frame replaced
  std::uint64_t widened = 0;                   ///< times that a path was found to carry larger datagrams
  std::uint64_t black_holes = 0;               ///< paths that stopped to carry large datagrams
  friend bool operator==(const SessionCounters&, const SessionCounters&) = default;
};

/// What happens to clients that have a key but no session.
enum class Newcomers : std::uint8_t {
  Admitted,
  Ignored,  ///< their hellos are not answered: it is not known who may be admitted
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

  /// Queues the messages that answer a job, and counts the time that it has `taken`. Does nothing if the
  /// session has ended.
  void put(SessionId session, std::vector<std::vector<std::byte>> messages, Duration taken, Time now,
           JobEnd end = JobEnd::Answered);

  /// Whether the job that the worker has is to be given up: its session has ended, or it takes too long
  /// (rt_server/scheduling/job_costs.h) while a client of another key waits.
  [[nodiscard]] bool gives_up(Time now) const;

  /// From now on offers only `answers`. Sessions that use another answer end: their clients are told so,
  /// connect again and read in the Welcome what is offered.
  void offer(AnswerSet answers);

  /// From now on serves only clients with these keys, if they are valid on `today`. The sessions of other
  /// keys end.
  void set_ring(const std::vector<SharedKey>& ring, std::chrono::sys_days today = {});

  void admit(Newcomers newcomers) { newcomers_ = newcomers; }

  /// Queues the news for all clients that the server ends.
  void say_goodbye();
  /// When the next goodbye leaves; nothing if none is left.
  [[nodiscard]] std::optional<Time> goodbye_at() const;

  /// The server did not run for so long, and has not yet read what came meanwhile: its clients were not
  /// silent.
  void forgive(Duration stall, Time now);

  /// Seals the next datagram that is due, for `to`. Returns false if none is. When the limit of all sessions
  /// lets only some go, it is one of the key that was sent the least.
  bool seal_due(Time now, Peer& to, std::vector<std::byte>& datagram);

  /// When next_job() or seal_due() next has something to do if no datagram arrives. A time in the past means
  /// now.
  [[nodiscard]] std::optional<Time> job_at() const;
  [[nodiscard]] std::optional<Time> due_at() const;

  [[nodiscard]] std::size_t size() const { return sessions_.size(); }
  /// Memory that all sessions hold.
  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_; }
  /// What the holder of a key of the ring has used.
  [[nodiscard]] const KeyAccount& account(const KeyId& key) { return ledger_.of(key); }
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
  [[nodiscard]] std::optional<RefusalReason> why_refused(const Hello& hello, bool key_full, bool has_room);
  void begin_session(const SharedKey& key, const Peer& client, const Hello& hello, const Accepted& accepted,
                     Time now);
  void count(ReceivedMessage received);
  void end_replaced(SessionId kept);
  void end_beyond_limit(SessionId kept);
  [[nodiscard]] Time end_of(const ClientSession& session) const;
  void share_limits();
  template <class IsOver>
  std::uint64_t end_sessions(ClientEvent::Kind why, const IsOver& is_over);
  [[nodiscard]] ClientSession* find(SessionId id);
  [[nodiscard]] const ClientSession* to_displace(const KeyId& newcomer) const;
  void end_displaced(SessionId id);
  void end_left(SessionId id);
  void queue_goodbye(ClientSession& session, EndReason reason);
  /// A session that is silent for so long makes room for another one of a key that has no more.
  static constexpr Duration kReplaceable = std::chrono::seconds(1);
  [[nodiscard]] bool is_key_full(const SharedKey& key, const Peer& from, Time now) const;
  void log_refusal(const Peer& from, const Hello& hello, const GateCounters& before);

  /// A hello of which nothing more comes: it was refused, or its session has ended. While its cookie is valid
  /// anybody can send it again from its address; it then costs no handshake.
  struct SpentHello {
    KeyId key{};
    PublicKey client{};
    std::vector<std::byte> answer;  ///< empty: none
    Time until{};                   ///< when no cookie of it is valid any more: a newer one shows its client
  };
  /// Twice as many as the usual limit of handshakes lets begin while a cookie is valid; the oldest gives way.
  static constexpr std::size_t kMostSpentHellos = 1024;
  void remember(const KeyId& key, const PublicKey& client, const std::vector<std::byte>& answer);

  Welcome served_;
  SessionLimits limits_;
  Gate gate_;
  std::vector<ClientSession> sessions_;
  // What a stranger's datagram needs, so that its cost does not grow with the number of sessions.
  std::unordered_map<std::uint64_t, std::size_t> place_of_;  ///< in sessions_, by SessionId
  std::optional<Time> silent_at_;
  Newcomers newcomers_ = Newcomers::Admitted;
  mutable std::optional<std::optional<Time>> due_at_;  ///< no value: to be found anew
  bool was_opened_ = false;
  KeyLedger ledger_;
  Turns turns_;
  std::uint64_t sent_ = 0;  ///< KeyAccount::sent_bytes of the key sent to last: a key that had nothing to do
                            ///< starts at this value
  Time may_send_at_{};      ///< because of the limit of all sessions together
  /// The job that the worker has. Its key owes its work even if the session ends meanwhile.
  struct InWork {
    SessionId session;
    KeyId key;
    JobSize size;
    Time begun;
  };
  std::optional<InWork> in_work_;
  [[nodiscard]] ClientSession* next_session(Time now);
  [[nodiscard]] bool is_too_costly(const InWork& job);
  void charge(Duration work, Time now, JobEnd end);
  [[nodiscard]] std::size_t room_for(const KeyId& key);
  void hold(const ClientSession& session, std::size_t before);
  void hold(const KeyId& key, std::size_t now, std::size_t before);
  std::size_t held_bytes_ = 0;
  std::size_t held_beyond_bytes_ = 0;  ///< the parts that keys hold beyond what each is guaranteed
  SessionCounters counters_;
  std::vector<ClientEvent> events_;
  /// The last datagrams for a client whose session has ended: what loses one may lose the next one, too, so
  /// they leave apart.
  struct Farewell {
    Peer to;
    std::vector<std::vector<std::byte>> datagrams;
    Time due{};
  };
  std::vector<Farewell> farewells_;
  std::deque<SpentHello> spent_;
  Time now_{};  ///< of the last datagram
};

}  // namespace farshade
