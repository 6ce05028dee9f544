#include "rt_server/sessions/send_order.h"

#include <algorithm>
#include <utility>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// What the limit of all sessions did not use in this time may follow at once.
constexpr Duration kBurst = std::chrono::milliseconds(2);

}  // namespace

std::optional<Time> SendOrder::due_at(const SessionTable& sessions) const {
  std::optional<Time> earliest;
  for (const ClientSession& session : sessions)
    if (const std::optional<Time> at = session.due(); at && (!earliest || *at < *earliest)) earliest = at;
  if (earliest) earliest = std::max(*earliest, may_send_at_);
  return earliest;
}

ClientSession& SendOrder::next(SessionTable& sessions, KeyLedger& ledger, Time now) {
  ClientSession* next = nullptr;
  const auto order = [&](const ClientSession& session) {
    return std::pair(ledger.of(session.key()).sent_bytes, *session.due());
  };
  for (ClientSession& session : sessions) {
    if (!session.due() || *session.due() > now) continue;
    KeyAccount& account = ledger.of(session.key());
    account.sent_bytes = std::max(account.sent_bytes, sent_);
    if (next == nullptr || order(session) < order(*next)) next = &session;
  }
  check(next != nullptr, "a datagram is due");
  return *next;
}

void SendOrder::sent(KeyAccount& account, std::size_t bytes, Time now) {
  sent_ = account.sent_bytes;
  account.sent_bytes += bytes;
  may_send_at_ = std::max(may_send_at_, now - kBurst) +
                 duration_from_ms(1e3 * static_cast<double>(bytes) / total_bytes_per_second_);
}

}  // namespace farshade
