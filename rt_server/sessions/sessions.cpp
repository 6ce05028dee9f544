#include "rt_server/sessions/sessions.h"

#include <algorithm>

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

/// A way in which sessions end.
struct Ending {
  ClientEvent::Kind why;
  std::uint64_t SessionCounters::*counter;
  std::optional<EndReason> told{};  ///< to the client; nothing if it knows or does not listen
};

const Ending& ending_of(ClientEvent::Kind why) {
  using enum ClientEvent::Kind;
  static constexpr Ending kEndings[]{
      {Left, &SessionCounters::left},
      {FellSilent, &SessionCounters::forgotten},
      {Replaced, &SessionCounters::replaced},
      {Withdrawn, &SessionCounters::withdrawn, EndReason::Withdrawn},
      {Displaced, &SessionCounters::displaced, EndReason::Displaced},
      {Revoked, &SessionCounters::revoked, EndReason::Revoked},
      {Expired, &SessionCounters::expired, EndReason::Expired},
  };
  const auto found = std::ranges::find(kEndings, why, &Ending::why);
  check(found != std::end(kEndings), "a session ends for one of these reasons");
  return *found;
}

}  // namespace

Sessions::Sessions(const Welcome& served, const std::vector<SharedKey>& ring, const SessionLimits& limits)
    : served_(served),
      limits_(limits),
      gate_(ring, limits.handshakes_per_second),
      sessions_(limits.silence, limits.unconfirmed),
      ledger_(limits.handshakes_per_second, limits.memory),
      sending_(limits.total_bytes_per_second) {
  check(limits.unconfirmed > kCookieLife && limits.silence > kCookieLife,
        "a session lives longer than a cookie: a repeated hello finds the session that it began");
  sessions_.reserve(limits.sessions);
  ledger_.keep(gate_.ring());
}

Decoded<void> Sessions::handle(const Peer& from, std::span<const std::byte> datagram, Time now,
                               std::vector<std::byte>& answer) {
  answer.clear();
  was_opened_ = false;
  spent_.advance(now);
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
  const GateCounters before = gate_.counters();
  const SharedKey* const key = gate_.admit(from, hello, datagram, now, answer);
  if (key == nullptr) return log_refusal(from, hello, before);
  if (const ClientSession* const known = sessions_.find(hello)) {
    ++counters_.repeated;
    answer.assign(known->accept_datagram().begin(), known->accept_datagram().end());
    return;
  }
  if (const std::vector<std::byte>* const spent = spent_.answer_to(hello)) {
    ++counters_.repeated;
    answer = *spent;
    return;
  }
  if (newcomers_ == Newcomers::Ignored) {
    ++counters_.ignored;
    return;
  }
  if (!gate_.may_shake_hands(ledger_.of(hello.key).handshakes, now))
    return log(ClientEvent::Kind::TooManyHandshakes, key->name, from, hello.key);
  const bool is_full = sessions_.size() == limits_.sessions;
  const ClientSession* const displaced = is_full ? sessions_.to_displace(hello.key) : nullptr;
  const bool has_room = !is_full || displaced != nullptr, key_full = is_key_full(*key, from, now);
  const std::optional<RefusalReason> refused = why_refused(hello, key_full, has_room);
  const ServerMessage message =
      refused ? ServerMessage(Refusal{*refused, served_.scene_hash}) : ServerMessage(served_);
  const std::optional<Accepted> accepted = accept(hello, datagram, *key, message);
  if (!accepted) return;
  answer = accepted->datagram;
  const bool by_key = key_full && refused == RefusalReason::Busy;
  log(by_key ? ClientEvent::Kind::TooManySessions : kind_of(refused, hello.scene_hash), key->name, from,
      hello.key);
  if (refused) return spent_.add(hello.key, hello.client, answer);
  if (displaced != nullptr) end_session(ClientEvent::Kind::Displaced, displaced->id());
  begin_session(*key, from, hello, *accepted, now);
}

/// Counts the reason.
std::optional<RefusalReason> Sessions::why_refused(const Hello& hello, bool key_full, bool has_room) {
  if (hello.scene_hash != served_.scene_hash) {
    ++counters_.scene_mismatch;
    return RefusalReason::SceneMismatch;
  }
  if (key_full)
    ++counters_.key_full;
  else if (!has_room)
    ++counters_.busy;
  else if (ledger_.room_for(hello.key) < kSession_bytes)
    ++counters_.over_memory;
  else
    return std::nullopt;
  return RefusalReason::Busy;
}

void Sessions::begin_session(const SharedKey& key, const Peer& client, const Hello& hello,
                             const Accepted& accepted, Time now) {
  ++counters_.welcomed;
  ClientSession& session = sessions_.add(
      {key, client, hello.client, accepted, now, limits_up_to(limits_.bytes_per_second), served_});
  if (key.limits.bytes_per_second) sessions_.share_limits(gate_.ring(), limits_.bytes_per_second);
  session.turn = jobs_.turn_of_newcomer(ledger_.of(hello.key));
  hold(session, 0);
}

void Sessions::log(ClientEvent::Kind kind, const std::string& who, const Peer& from, const KeyId& key) {
  events_.push_back({kind, who, from, {}, key});
}

void Sessions::log_refusal(const Peer& from, const Hello& hello, const GateCounters& before) {
  if (gate_.counters().unknown_key != before.unknown_key)
    events_.push_back({ClientEvent::Kind::NotAdmitted, explain(hello.key, gate_.ring(), from), from});
  if (gate_.counters().expired_key != before.expired_key)
    log(ClientEvent::Kind::KeyExpired, gate_.expired().at(hello.key).name, from, hello.key);
}

/// Sessions at the newcomer's own address do not count, nor do silent ones: its client was started anew, or
/// another one has ended without a word. They end with its first datagram (end_beyond_limit).
bool Sessions::is_key_full(const SharedKey& key, const Peer& from, Time now) const {
  if (!key.limits.sessions) return false;
  const KeyId id = id_of(key);
  const auto others = std::ranges::count_if(sessions_, [&](const ClientSession& session) {
    return session.key() == id && session.client() != from && now - session.last_received() < kReplaceable;
  });
  return static_cast<std::uint64_t>(others) >= *key.limits.sessions;
}

void Sessions::queue_goodbye(ClientSession& session, EndReason reason) {
  const std::size_t before = session.bytes();
  std::vector<std::vector<std::byte>> datagrams(kGoodbyes);
  for (std::vector<std::byte>& datagram : datagrams) session.seal_goodbye(reason, datagram);
  farewells_.add(session.client(), std::move(datagrams));
  hold(session, before);
  due_at_.reset();
}

void Sessions::say_goodbye() {
  for (ClientSession& session : sessions_) queue_goodbye(session, EndReason::ServerEnds);
}

Decoded<void> Sessions::handle_sealed(const Peer& from, const Sealed& sealed,
                                      std::span<const std::byte> datagram, Time now,
                                      std::vector<std::byte>& answer) {
  ClientSession* const session = sessions_.find(sealed.session);
  if (session == nullptr) {
    encode(NoSession{sealed.session, sealed.version}, answer);
    check(answer.size() <= datagram.size(), "an answer is no longer than the datagram that it answers");
    return refuse(WireRefusal::UnknownSession);
  }
  const bool first = !session->is_confirmed();
  const Peer client_before = session->client();
  const std::size_t before = session->bytes();
  const bool got_false_report = session->got_false_report();
  const std::uint64_t holes_before = session->black_holes();
  const std::size_t carried_before = session->most_datagram_bytes();
  const Decoded<ReceivedMessage> received =
      session->receive(from, sealed, datagram, now, answer, ledger_.room_for(session->key()));
  hold(*session, before);
  if (session->client() != client_before) ++counters_.moved;
  if (session->got_false_report() && !got_false_report) ++counters_.false_reports;
  if (session->black_holes() > holes_before) ++counters_.black_holes;
  if (session->most_datagram_bytes() > carried_before) ++counters_.widened;
  if (received == ReceivedMessage::Left) {
    end_session(ClientEvent::Kind::Left, sealed.session);
    return {};
  }
  if (received == ReceivedMessage::NewRequest || received == ReceivedMessage::Superseded)
    jobs_.was_active(session->key(), now);
  if (first && session->is_confirmed()) {
    const KeyId key = session->key();
    end_replaced(*session);
    end_beyond_limit(key, sealed.session);
  }
  if (!received) return refuse(received.error());
  was_opened_ = true;
  counters_.count(*received);
  return {};
}

/// A client that was restarted at its address does not need its older session any more. The reference is not
/// valid afterwards.
void Sessions::end_replaced(const ClientSession& kept) {
  const std::string name = kept.name();
  const Peer client = kept.client();
  end_sessions(ClientEvent::Kind::Replaced, [&, id = kept.id()](const ClientSession& session) {
    return session.id() != id && session.name() == name && session.client() == client;
  });
}

/// Sessions may have been let in beyond the limit of their key. Those that have been silent longest end.
void Sessions::end_beyond_limit(KeyId key, SessionId kept) {
  const auto entry = gate_.ring().find(key);
  if (entry == gate_.ring().end() || !entry->second.limits.sessions) return;
  while (const ClientSession* const silent =
             sessions_.beyond_limit(key, *entry->second.limits.sessions, kept))
    end_session(ClientEvent::Kind::Replaced, silent->id());
}

void Sessions::end_session(ClientEvent::Kind why, SessionId id) {
  end_sessions(why, [&](const ClientSession& session) { return session.id() == id; });
}

template <class IsOver>
void Sessions::end_sessions(ClientEvent::Kind why, const IsOver& is_over) {
  const Ending& ending = ending_of(why);
  for (ClientSession& session : sessions_)
    if (ending.told && is_over(session)) queue_goodbye(session, *ending.told);
  const std::size_t ended = sessions_.erase_if([&](const ClientSession& session) {
    if (!is_over(session)) return false;
    const bool goes = why == ClientEvent::Kind::Left || why == ClientEvent::Kind::FellSilent;
    const bool said_nothing = goes && !session.has_requested();
    events_.push_back({said_nothing ? ClientEvent::Kind::SaidNothing : why, session.name(), session.client(),
                       session.last_received() - session.began(), session.key()});
    ledger_.hold(session.key(), 0, session.bytes());
    // A silent one has outlived its cookies.
    if (why != ClientEvent::Kind::FellSilent) spent_.add(session.key(), session.hello(), {});
    return true;
  });
  if (ended == 0) return;
  counters_.*ending.counter += ended;
  due_at_.reset();
  sessions_.share_limits(gate_.ring(), limits_.bytes_per_second);
}

void Sessions::offer(AnswerSet answers) {
  served_.answers = answers;
  end_sessions(ClientEvent::Kind::Withdrawn, [&](const ClientSession& session) {
    return !session.requested_answer() || (set_of(*session.requested_answer()) & answers) == 0;
  });
  for (ClientSession& session : sessions_) session.offer(answers);
}

void Sessions::set_ring(const std::vector<SharedKey>& ring, std::chrono::sys_days today) {
  gate_.set_ring(ring, today);
  end_sessions(ClientEvent::Kind::Expired,
               [&](const ClientSession& session) { return gate_.expired().contains(session.key()); });
  end_sessions(ClientEvent::Kind::Revoked,
               [&](const ClientSession& session) { return !gate_.ring().contains(session.key()); });
  ledger_.keep(gate_.ring());
  jobs_.keep(gate_.ring());
  sessions_.share_limits(gate_.ring(), limits_.bytes_per_second);
}

std::optional<Job> Sessions::next_job(Time now) {
  ClientSession* const next = jobs_.next(sessions_, ledger_, now);
  if (next == nullptr) return std::nullopt;
  const std::size_t before = next->bytes();
  Job job = jobs_.begin(*next, sessions_, ledger_, now);
  hold(*next, before);
  if (job.is_too_costly) ++counters_.too_costly;
  if (answer_bytes(job.request, served_.light_count) > limits_.memory.in_work()) {
    job.is_too_costly = true;
    ++counters_.over_memory;
  }
  return job;
}

void Sessions::put(SessionId id, std::vector<std::vector<std::byte>> messages, Duration taken, Time now,
                   JobEnd end) {
  const Duration work = std::min(taken, kMostCharged);
  jobs_.end(id, sessions_, gate_.ring(), work, now, end);
  ClientSession* const session = sessions_.find(id);
  if (session == nullptr) return;
  session->turn.work += work;
  due_at_.reset();
  std::size_t bytes = 0;
  for (const std::vector<std::byte>& message : messages) bytes += message.capacity() + kMessage_bytes;
  if (bytes > ledger_.room_for(session->key())) {  // only the report is sent
    ++counters_.over_memory;
    messages.erase(messages.begin(), messages.end() - 1);
    end = JobEnd::GivenUp;
  }
  const std::size_t bytes_before = session->bytes();
  const auto [is_held_back, overtakes] = session->put(std::move(messages), now, end);
  hold(*session, bytes_before);
  if (is_held_back) ++counters_.held_back;
  if (overtakes) ++counters_.overtaken;
}

bool Sessions::seal_due(Time now, Peer& to, std::vector<std::byte>& datagram) {
  if (farewells_.take(now, to, datagram)) {
    due_at_.reset();
    return true;
  }
  if (const std::optional<Time> due = due_at(); !due || *due > now) return false;
  ClientSession& next = sending_.next(sessions_, ledger_, now);
  due_at_.reset();
  to = next.client();
  const std::size_t before = next.bytes();
  next.seal_due(now, datagram);
  hold(next, before);
  sending_.sent(ledger_.of(next.key()), datagram.size(), now);
  return true;
}

std::optional<Time> Sessions::due_at() const {
  if (due_at_) return *due_at_;
  std::optional<Time> earliest = sending_.due_at(sessions_);
  if (const std::optional<Time> at = goodbye_at(); at && (!earliest || *at < *earliest)) earliest = at;
  due_at_ = earliest;
  return earliest;
}

void Sessions::end_silent(Time now) {
  if (!silent_at() || now < *silent_at()) return;
  end_sessions(ClientEvent::Kind::FellSilent,
               [&](const ClientSession& session) { return sessions_.is_silent(session, now); });
  sessions_.find_silent_at();
}

}  // namespace farshade
