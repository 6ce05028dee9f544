#include "rt_server/sessions/job_order.h"

#include <algorithm>
#include <utility>

namespace farshade {

ClientSession* JobOrder::next(SessionTable& sessions, KeyLedger& ledger, Time now) {
  turns_.look(now);
  ClientSession *next = nullptr, *held = nullptr;
  const auto order = [&](const ClientSession& session) {
    return std::pair(turns_.order(session.key()), session.turn);
  };
  for (ClientSession& session : sessions) {
    if (!session.is_ready(now)) continue;
    session.turn.work = std::max(session.turn.work, ledger.of(session.key()).session_work);
    ClientSession*& least = turns_.is_held(session.key(), now) ? held : next;
    if (least == nullptr || order(session) < order(*least)) least = &session;
  }
  if (next == nullptr && held != nullptr) turns_.wait_for_others(held->key(), now);
  return next;
}

std::optional<Time> JobOrder::look_at(const SessionTable& sessions) const {
  std::optional<Time> earliest;
  for (const ClientSession& session : sessions)
    if (std::optional<Time> at = session.ready_at()) {
      at = std::max(*at, turns_.look_at(session.key()).value_or(*at));
      if (!earliest || *at < *earliest) earliest = at;
    }
  return earliest;
}

Job JobOrder::begin(ClientSession& next, const SessionTable& sessions, KeyLedger& ledger, Time now) {
  ledger.of(next.key()).session_work = next.turn.work;
  next.turn.served = turns_.begin(next.key());
  Job job = next.take_job();
  in_work_ = {next.id(), next.key(), size_of(job.request), now};
  job.is_too_costly = is_too_costly(*in_work_, sessions);
  if (job.is_too_costly) turns_.costs(next.key()).was_refused(in_work_->size, now);
  return job;
}

bool JobOrder::is_too_costly(const InWork& job, const SessionTable& sessions) {
  if (job.size.is_usual || turns_.costs(job.key).estimate(job.size) <= kMostTurn) return false;
  return std::ranges::any_of(sessions, [&](const ClientSession& session) {
    return session.key() != job.key && job.begun - session.last_received() <= kPresent;
  });
}

bool JobOrder::gives_up(const SessionTable& sessions, Time now) const {
  if (!in_work_) return false;
  if (!sessions.contains(in_work_->session)) return true;
  if (in_work_->size.is_usual || now - in_work_->begun <= kMostTurn) return false;
  return std::ranges::any_of(sessions, [&](const ClientSession& session) {
    return session.key() != in_work_->key && session.is_ready(now);
  });
}

void JobOrder::end(SessionId id, const SessionTable& sessions, const KeyRing& ring, Duration work, Time now,
                   JobEnd how) {
  if (!in_work_ || in_work_->session != id || !ring.contains(in_work_->key)) return;
  for (const ClientSession& session : sessions)
    if (session.is_ready(now)) turns_.was_active(session.key(), now);
  turns_.end(in_work_->key, work, now);
  JobCosts& costs = turns_.costs(in_work_->key);
  if (how == JobEnd::Answered)
    costs.took(in_work_->size, work);
  else if (work > kMostTurn)
    costs.was_given_up(in_work_->size, work);
}

}  // namespace farshade
