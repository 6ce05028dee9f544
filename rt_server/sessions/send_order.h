/// SendOrder: from which session the next datagram leaves, when the limit of all sessions lets only some go:
/// of the key that was sent the least. So each key has its part of the server's link. A value without clocks.
#pragma once

#include <cstddef>
#include <optional>

#include "rt_server/admission/key_ledger.h"
#include "rt_server/sessions/session_table.h"

namespace farshade {

class SendOrder {
 public:
  explicit SendOrder(double total_bytes_per_second) : total_bytes_per_second_(total_bytes_per_second) {}

  /// When the next datagram leaves; nothing if none waits.
  [[nodiscard]] std::optional<Time> due_at(const SessionTable& sessions) const;

  /// Of the sessions that have a datagram due at `now`, the one whose datagram leaves. At least one has.
  [[nodiscard]] ClientSession& next(SessionTable& sessions, KeyLedger& ledger, Time now);
  /// A datagram of the session that was next has left, for the account of its key.
  void sent(KeyAccount& account, std::size_t bytes, Time now);

 private:
  double total_bytes_per_second_;
  std::uint64_t sent_ = 0;  ///< KeyAccount::sent_bytes of the key sent to last: a key that had nothing to do
                            ///< starts at this value
  Time may_send_at_{};      ///< because of the limit of all sessions together
};

}  // namespace farshade
