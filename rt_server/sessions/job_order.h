/// JobOrder: whose request is answered next, and the job that the worker has. The key on whose clients the
/// least work was spent is served next (rt_server/scheduling/turns.h), and of its sessions the one on which
/// the least was spent; among equals, the one that was served longest ago. A value without clocks.
#pragma once

#include <optional>

#include "rt_server/admission/key_ledger.h"
#include "rt_server/scheduling/turns.h"
#include "rt_server/sessions/session_table.h"

namespace farshade {

class JobOrder {
 public:
  /// The accounts of keys that are not in `ring` end.
  void keep(const KeyRing& ring) { turns_.keep(ring); }
  /// A client of `key` has asked.
  void was_active(const KeyId& key, Time now) { turns_.was_active(key, now); }
  /// Where a new session of the key with this account starts.
  [[nodiscard]] ClientSession::Turn turn_of_newcomer(const KeyAccount& account) const {
    return {account.session_work, turns_.jobs()};
  }

  /// The session whose request is answered now; null if there is none.
  [[nodiscard]] ClientSession* next(SessionTable& sessions, KeyLedger& ledger, Time now);
  /// When next() has to look again if no datagram arrives; nothing if no request waits.
  [[nodiscard]] std::optional<Time> look_at(const SessionTable& sessions) const;

  /// Takes the request of `next`, one of the `sessions`, for the worker. It is too costly if it is expected
  /// to take too long (rt_server/scheduling/job_costs.h) while a client of another key is present.
  [[nodiscard]] Job begin(ClientSession& next, const SessionTable& sessions, KeyLedger& ledger, Time now);
  /// Whether the worker is to give up its job: its session has ended, or it takes too long while a client of
  /// another key waits.
  [[nodiscard]] bool gives_up(const SessionTable& sessions, Time now) const;
  /// The job of session `id` has ended and has taken `work`, which its key owes even if the session has
  /// ended.
  void end(SessionId id, const SessionTable& sessions, const KeyRing& ring, Duration work, Time now,
           JobEnd how);

 private:
  /// The job that the worker has.
  struct InWork {
    SessionId session;
    KeyId key;
    JobSize size;
    Time begun;
  };
  [[nodiscard]] bool is_too_costly(const InWork& job, const SessionTable& sessions);

  Turns turns_;
  std::optional<InWork> in_work_;
};

}  // namespace farshade
