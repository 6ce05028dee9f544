#include "rt_server/core/sessions.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "stereo/base/check.h"
#include "stereo/net/explain.h"

namespace farshade {
namespace {

ClientEvent::Kind kind_of(std::optional<RefusalReason> refused, const ContentHash& scene) {
  using enum ClientEvent::Kind;
  if (!refused) return Welcomed;
  if (*refused == RefusalReason::Busy) return Busy;
  return scene == kNoScene ? AskedForScene : OtherScene;
}

}  // namespace

Sessions::Sessions(const Welcome& served, const std::vector<SharedKey>& ring, const SessionLimits& limits)
    : served_(served),
      limits_(limits),
      gate_(ring, limits.handshakes_per_second),
      ledger_(limits.handshakes_per_second) {
  check(limits.unconfirmed > kCookieLife && limits.silence > kCookieLife,
        "a session lives longer than a cookie: a repeated hello finds the session that it began");
  sessions_.reserve(limits.sessions);
  ledger_.keep(gate_.ring());
}

Decoded<void> Sessions::handle(const Peer& from, std::span<const std::byte> datagram, Time now,
                               std::vector<std::byte>& answer) {
  answer.clear();
  was_opened_ = false;
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
  const std::uint64_t unknown_before = gate_.counters().unknown_key;
  const SharedKey* const key = gate_.admit(from, hello, datagram, now, answer);
  if (gate_.counters().unknown_key != unknown_before)
    events_.push_back({ClientEvent::Kind::NotAdmitted, explain(hello.key, gate_.ring(), from), from});
  if (key == nullptr) return;
  // Anybody can see the public key of a hello and send it under another key.
  const auto known = std::ranges::find_if(sessions_, [&](const ClientSession& session) {
    return session.hello() == hello.client && session.key() == hello.key;
  });
  if (known != sessions_.end()) {
    ++counters_.repeated;
    answer.assign(known->accept_datagram().begin(), known->accept_datagram().end());
    return;
  }
  KeyAccount& account = ledger_.of(hello.key);
  if (!gate_.may_shake_hands(account.handshakes, now)) return;
  std::optional<RefusalReason> refused;
  const bool is_full = sessions_.size() == limits_.sessions;
  const ClientSession* const displaced = is_full ? to_displace(hello.key) : nullptr;
  if (hello.scene_hash != served_.scene_hash) {
    refused = RefusalReason::SceneMismatch;
    ++counters_.scene_mismatch;
  } else if (is_full && displaced == nullptr) {
    refused = RefusalReason::Busy;
    ++counters_.busy;
  }
  const ServerMessage message =
      refused ? ServerMessage(Refusal{*refused, served_.scene_hash}) : ServerMessage(served_);
  const std::optional<Accepted> accepted = accept(hello, datagram, *key, message);
  if (!accepted) return;
  answer = accepted->datagram;
  events_.push_back({kind_of(refused, hello.scene_hash), key->name, from});
  if (refused) return;
  ++counters_.welcomed;
  if (displaced != nullptr) end_displaced(displaced->id());
  sessions_.emplace_back(*key, from, hello.client, *accepted, now,
                         RateLimits{.most = limits_.bytes_per_second}, served_);
  sessions_.back().turn = {account.session_work, jobs_};
  place_of_[sessions_.back().id().value] = sessions_.size() - 1;
  const Time end = end_of(sessions_.back()) + Duration(1);
  silent_at_ = silent_at_ ? std::min(*silent_at_, end) : end;
}

/// When the server is full: the newest session of the key with the most, if the newcomer's key then has no
/// more than that key. Null if the newcomer must wait.
const ClientSession* Sessions::to_displace(const KeyId& newcomer) const {
  std::map<KeyId, std::size_t> sessions_of;
  for (const ClientSession& session : sessions_) ++sessions_of[session.key()];
  const std::size_t own = sessions_of[newcomer];
  const auto most = std::ranges::max_element(sessions_of, {}, [](const auto& entry) { return entry.second; });
  if (most->second < own + 2) return nullptr;
  const ClientSession* newest = nullptr;
  for (const ClientSession& session : sessions_)
    if (session.key() == most->first && (newest == nullptr || session.began() >= newest->began()))
      newest = &session;
  return newest;
}

void Sessions::end_displaced(SessionId id) {
  counters_.displaced += end_sessions(ClientEvent::Kind::Displaced,
                                      [&](const ClientSession& session) { return session.id() == id; });
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
  const std::uint64_t holes_before = session->black_holes();
  const Decoded<ReceivedMessage> received = session->receive(from, sealed, datagram, now, answer);
  if (session->client() != before) ++counters_.moved;
  if (session->black_holes() > holes_before) ++counters_.black_holes;
  if (first && session->is_confirmed()) end_replaced(session->id());
  if (!received) return refuse(received.error());
  was_opened_ = true;
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
  counters_.replaced += end_sessions(ClientEvent::Kind::Replaced, [&](const ClientSession& session) {
    return session.id() != kept && session.name() == name && session.client() == client;
  });
}

template <class IsOver>
std::uint64_t Sessions::end_sessions(ClientEvent::Kind why, const IsOver& is_over) {
  const std::uint64_t ended = std::erase_if(sessions_, [&](const ClientSession& session) {
    if (!is_over(session)) return false;
    const bool said_nothing = why == ClientEvent::Kind::Left && !session.is_confirmed();
    events_.push_back({said_nothing ? ClientEvent::Kind::SaidNothing : why, session.name(), session.client(),
                       session.last_received() - session.began()});
    return true;
  });
  if (ended == 0) return 0;
  due_at_.reset();
  place_of_.clear();
  for (std::size_t i = 0; i < sessions_.size(); ++i) place_of_[sessions_[i].id().value] = i;
  return ended;
}

void Sessions::offer(AnswerSet answers) {
  served_.answers = answers;
  counters_.withdrawn += end_sessions(ClientEvent::Kind::Withdrawn, [&](const ClientSession& session) {
    return !session.requested_answer() || (set_of(*session.requested_answer()) & answers) == 0;
  });
  for (ClientSession& session : sessions_) session.offer(answers);
}

void Sessions::set_ring(const std::vector<SharedKey>& ring) {
  gate_.set_ring(ring);
  ledger_.keep(gate_.ring());
  counters_.revoked += end_sessions(ClientEvent::Kind::Revoked, [&](const ClientSession& session) {
    return !gate_.ring().contains(session.key());
  });
}

std::optional<Job> Sessions::next_job(Time now) {
  ClientSession* next = nullptr;
  const auto order = [&](const ClientSession& session) {
    const KeyAccount& account = ledger_.of(session.key());
    return std::tuple(account.work, account.served, session.turn);
  };
  for (ClientSession& session : sessions_) {
    if (!session.is_ready(now)) continue;
    KeyAccount& account = ledger_.of(session.key());
    account.work = std::max(account.work, work_);
    session.turn.work = std::max(session.turn.work, account.session_work);
    if (next == nullptr || order(session) < order(*next)) next = &session;
  }
  if (next == nullptr) return std::nullopt;
  KeyAccount& account = ledger_.of(next->key());
  work_ = account.work;
  account.session_work = next->turn.work;
  account.served = next->turn.served = ++jobs_;
  in_work_ = {next->id(), next->key()};
  return next->take_job();
}

void Sessions::put(SessionId id, std::span<const std::vector<std::byte>> messages, Duration work, Time now) {
  ClientSession* const session = find(id);
  if (session != nullptr)
    ledger_.of(session->key()).work += work;
  else if (in_work_ && in_work_->first == id && gate_.ring().contains(in_work_->second))
    ledger_.of(in_work_->second).work += work;
  if (session == nullptr) return;
  session->turn.work += work;
  due_at_.reset();
  const std::uint64_t before = session->held_back();
  session->put(messages, now);
  counters_.held_back += session->held_back() - before;
}

bool Sessions::seal_due(Time now, Peer& to, std::vector<std::byte>& datagram) {
  if (const std::optional<Time> due = due_at(); !due || *due > now) return false;
  ClientSession* next = nullptr;
  for (ClientSession& session : sessions_)
    if (session.due() && *session.due() <= now && (next == nullptr || *session.due() < *next->due()))
      next = &session;
  check(next != nullptr, "a datagram is due");
  due_at_.reset();
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
  if (due_at_) return *due_at_;
  std::optional<Time> earliest;
  for (const ClientSession& session : sessions_)
    if (const std::optional<Time> at = session.due(); at && (!earliest || *at < *earliest)) earliest = at;
  due_at_ = earliest;
  return earliest;
}

ClientSession* Sessions::find(SessionId id) {
  const auto found = place_of_.find(id.value);
  return found == place_of_.end() ? nullptr : &sessions_[found->second];
}

Time Sessions::end_of(const ClientSession& session) const {
  return session.last_received() + (session.is_confirmed() ? limits_.silence : limits_.unconfirmed);
}

void Sessions::end_silent(Time now) {
  if (!silent_at_ || now < *silent_at_) return;
  counters_.forgotten += end_sessions(ClientEvent::Kind::Left,
                                      [&](const ClientSession& session) { return now > end_of(session); });
  silent_at_.reset();
  for (const ClientSession& session : sessions_)
    if (const Time end = end_of(session) + Duration(1); !silent_at_ || end < *silent_at_) silent_at_ = end;
}

}  // namespace farshade
