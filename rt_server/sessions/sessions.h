/// Sessions: which clients are connected. Lets clients in that the gate admits, gives each datagram to its
/// session, and ends sessions: of clients that left, fell silent, or must make room. A value without sockets,
/// threads or clocks.
///
/// The server stores only the newest request of each client. It counts the requests that a newer one
/// replaced. Whose request is answered next: job_order.h; whose datagram leaves next: send_order.h. A full
/// server takes a session from the key that has the most. Memory is bounded: the number of sessions and the
/// size of each are.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "rt_server/admission/gate.h"
#include "rt_server/admission/key_ledger.h"
#include "rt_server/log/client_event.h"
#include "rt_server/sessions/farewells.h"
#include "rt_server/sessions/job_order.h"
#include "rt_server/sessions/send_order.h"
#include "rt_server/sessions/session_counters.h"
#include "rt_server/sessions/session_table.h"
#include "rt_server/sessions/spent_hellos.h"

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

  /// Whether the job that the worker has is to be given up.
  [[nodiscard]] bool gives_up(Time now) const { return jobs_.gives_up(sessions_, now); }

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
  [[nodiscard]] std::optional<Time> goodbye_at() const { return farewells_.due_at(); }

  /// The server did not run for so long, and has not yet read what came meanwhile: its clients were not
  /// silent.
  void forgive(Duration stall, Time now) { sessions_.forgive(stall, now); }

  /// Seals the next datagram that is due, for `to`. Returns false if none is. When the limit of all sessions
  /// lets only some go, it is one of the key that was sent the least.
  bool seal_due(Time now, Peer& to, std::vector<std::byte>& datagram);

  /// When next_job() or seal_due() next has something to do if no datagram arrives. A time in the past means
  /// now.
  [[nodiscard]] std::optional<Time> job_at() const { return jobs_.look_at(sessions_); }
  [[nodiscard]] std::optional<Time> due_at() const;

  [[nodiscard]] std::size_t size() const { return sessions_.size(); }
  /// Memory that all sessions hold.
  [[nodiscard]] std::size_t held_bytes() const { return ledger_.held_bytes(); }
  /// What the holder of a key of the ring has used.
  [[nodiscard]] const KeyAccount& account(const KeyId& key) { return ledger_.of(key); }
  [[nodiscard]] const SessionCounters& counters() const { return counters_; }
  [[nodiscard]] const GateCounters& gate() const { return gate_.counters(); }

  /// Ends the sessions of clients that have been silent for too long. handle() does that, too.
  void end_silent(Time now);
  /// When end_silent() has to look at the sessions again if no datagram arrives: not after the first of them
  /// ends.
  [[nodiscard]] std::optional<Time> silent_at() const { return sessions_.silent_at(); }

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
  void end_replaced(const ClientSession& kept);
  void end_beyond_limit(KeyId key, SessionId kept);
  template <class IsOver>
  void end_sessions(ClientEvent::Kind why, const IsOver& is_over);
  void end_session(ClientEvent::Kind why, SessionId id);
  void queue_goodbye(ClientSession& session, EndReason reason);
  /// A session that is silent for so long makes room for another one of a key that has no more.
  static constexpr Duration kReplaceable = std::chrono::seconds(1);
  [[nodiscard]] bool is_key_full(const SharedKey& key, const Peer& from, Time now) const;
  void log(ClientEvent::Kind kind, const std::string& who, const Peer& from, const KeyId& key);
  void log_refusal(const Peer& from, const Hello& hello, const GateCounters& before);
  /// Accounts what `session` holds instead of the `before` bytes that it held.
  void hold(const ClientSession& session, std::size_t before) {
    ledger_.hold(session.key(), session.bytes(), before);
  }

  Welcome served_;
  SessionLimits limits_;
  Gate gate_;
  SessionTable sessions_;
  Newcomers newcomers_ = Newcomers::Admitted;
  mutable std::optional<std::optional<Time>> due_at_;  ///< no value: to be found anew
  bool was_opened_ = false;
  KeyLedger ledger_;
  JobOrder jobs_;
  SendOrder sending_;
  Farewells farewells_;
  SpentHellos spent_;
  SessionCounters counters_;
  std::vector<ClientEvent> events_;
};

}  // namespace farshade
