#include "rt_server/core/sessions.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {

Sessions::Sessions(const Welcome& served, const std::vector<SharedKey>& ring, const SessionLimits& limits)
    : served_(served), limits_(limits), gate_(ring, limits.handshakes_per_second) {
  check(limits.unconfirmed > kCookieLife && limits.silence > kCookieLife,
        "a session lives longer than a cookie: a repeated hello finds the session that it began");
  sessions_.reserve(limits.sessions);
}

Decoded<void> Sessions::handle(const Peer& from, std::span<const std::byte> datagram, Time now,
                               std::vector<std::byte>& answer) {
  answer.clear();
  end_silent(now);
  const Decoded<ClientEnvelope> envelope = open_client_envelope(datagram);
  if (!envelope) return refuse(envelope.error());
  if (const auto* sealed = std::get_if<Sealed>(&*envelope))
    return handle_sealed(from, *sealed, datagram, now, answer);
  if (const auto* foreign = std::get_if<ForeignHello>(&*envelope))
    gate_.refuse_version(*foreign, answer);
  else
    handle_hello(from, std::get<Hello>(*envelope), datagram, now, answer);
  check(answer.size() <= datagram.size(), "an answer is no longer than the datagram that it answers");
  return {};
}

void Sessions::handle_hello(const Peer& from, const Hello& hello, std::span<const std::byte> datagram,
                            Time now, std::vector<std::byte>& answer) {
  const SharedKey* const key = gate_.admit(from, hello, datagram, now, answer);
  if (key == nullptr) return;
  const auto known = std::ranges::find(sessions_, hello.client, &ClientSession::hello);
  if (known != sessions_.end()) {
    ++counters_.repeated;
    answer.assign(known->accept_datagram().begin(), known->accept_datagram().end());
    return;
  }
  if (!gate_.may_shake_hands(now)) return;
  std::optional<RefusalReason> refused;
  if (hello.scene_hash != served_.scene_hash) {
    refused = RefusalReason::SceneMismatch;
    ++counters_.scene_mismatch;
  } else if (sessions_.size() == limits_.sessions) {
    refused = RefusalReason::Busy;
    ++counters_.busy;
  }
  const ServerMessage message =
      refused ? ServerMessage(Refusal{*refused, served_.scene_hash}) : ServerMessage(served_);
  const std::optional<Accepted> accepted = accept(hello, datagram, *key, message);
  if (!accepted) return;
  answer = accepted->datagram;
  event_ = Event{key->name, from, refused};
  if (refused) return;
  ++counters_.welcomed;
  sessions_.emplace_back(key->name, from, hello.client, *accepted, now,
                         RateLimits{.most = limits_.bytes_per_second}, served_);
  sessions_.back().turn = {work_, jobs_};
}

Decoded<void> Sessions::handle_sealed(const Peer& from, const Sealed& sealed,
                                      std::span<const std::byte> datagram, Time now,
                                      std::vector<std::byte>& answer) {
  ClientSession* const session = find(sealed.session);
  if (session == nullptr) {
    encode(NoSession{sealed.session}, answer);
    check(answer.size() <= datagram.size(), "an answer is no longer than the datagram that it answers");
    return refuse(WireRefusal::UnknownSession);
  }
  const bool first = !session->is_confirmed();
  const Peer before = session->client();
  const Decoded<ReceivedMessage> received = session->receive(from, sealed, datagram, now, answer);
  if (session->client() != before) ++counters_.moved;
  if (first && session->is_confirmed()) end_replaced(session->id());
  if (!received) return refuse(received.error());
  count(*received);
  return {};
}

void Sessions::count(ReceivedMessage received) {
  if (received == ReceivedMessage::Stray) ++counters_.stray;
  if (received == ReceivedMessage::Stray || received == ReceivedMessage::Part) return;
  ++counters_.requests;
  if (received == ReceivedMessage::Unanswered) ++counters_.unanswered;
  if (received == ReceivedMessage::Superseded) ++counters_.superseded;
  if (received == ReceivedMessage::Outdated) ++counters_.outdated;
  if (received == ReceivedMessage::TooLarge) ++counters_.too_large;
}

/// A client that was restarted at its address does not need its older session any more.
void Sessions::end_replaced(SessionId kept) {
  const ClientSession& newer = *find(kept);
  const std::string name = newer.name();
  const Peer client = newer.client();
  counters_.replaced += std::erase_if(sessions_, [&](const ClientSession& session) {
    return session.id() != kept && session.name() == name && session.client() == client;
  });
}

void Sessions::offer(AnswerSet answers) {
  served_.answers = answers;
  counters_.withdrawn += std::erase_if(sessions_, [&](const ClientSession& session) {
    return !session.requested_answer() || (set_of(*session.requested_answer()) & answers) == 0;
  });
  for (ClientSession& session : sessions_) session.offer(answers);
}

std::optional<Job> Sessions::next_job(Time now) {
  ClientSession* next = nullptr;
  for (ClientSession& session : sessions_) {
    if (!session.is_ready(now)) continue;
    session.turn.work = std::max(session.turn.work, work_);
    if (next == nullptr || session.turn < next->turn) next = &session;
  }
  if (next == nullptr) return std::nullopt;
  work_ = next->turn.work;
  next->turn.served = ++jobs_;
  return next->take_job();
}

void Sessions::put(SessionId id, std::span<const std::vector<std::byte>> messages, Duration work, Time now) {
  ClientSession* const session = find(id);
  if (session == nullptr) return;
  session->turn.work += work;
  const std::uint64_t before = session->held_back();
  session->put(messages, now);
  counters_.held_back += session->held_back() - before;
}

bool Sessions::seal_due(Time now, Peer& to, std::vector<std::byte>& datagram) {
  ClientSession* next = nullptr;
  for (ClientSession& session : sessions_)
    if (session.due() && *session.due() <= now && (next == nullptr || *session.due() < *next->due()))
      next = &session;
  if (next == nullptr) return false;
  to = next->client();
  next->seal_due(now, datagram);
  return true;
}

std::optional<Time> Sessions::job_at() const {
  std::optional<Time> earliest;
  for (const ClientSession& session : sessions_)
    if (const std::optional<Time> at = session.ready_at(); at && (!earliest || *at < *earliest))
      earliest = at;
  return earliest;
}

std::optional<Time> Sessions::due_at() const {
  std::optional<Time> earliest;
  for (const ClientSession& session : sessions_)
    if (const std::optional<Time> at = session.due(); at && (!earliest || *at < *earliest)) earliest = at;
  return earliest;
}

ClientSession* Sessions::find(SessionId id) {
  const auto found = std::ranges::find(sessions_, id, &ClientSession::id);
  return found == sessions_.end() ? nullptr : &*found;
}

void Sessions::end_silent(Time now) {
  counters_.forgotten += std::erase_if(sessions_, [&](const ClientSession& session) {
    return now - session.last_received() > (session.is_confirmed() ? limits_.silence : limits_.unconfirmed);
  });
}

}  // namespace farshade
