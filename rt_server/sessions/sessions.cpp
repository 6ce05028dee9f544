#include "rt_server/sessions/sessions.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "stereo/base/check.h"
#include "stereo/net/explain.h"

namespace farshade {
namespace {

/// What the limit of all sessions did not use in this time may follow at once.
constexpr Duration kBurst = std::chrono::milliseconds(2);

ClientEvent::Kind kind_of(std::optional<RefusalReason> refused, const ContentHash& scene) {
  using enum ClientEvent::Kind;
  if (!refused) return Welcomed;
  if (*refused == RefusalReason::Busy) return Busy;
  return scene == kNoScene ? AskedForScene : OtherScene;
}

/// What the client of a session that ends for this reason is told; nothing if it knows or does not listen.
std::optional<EndReason> told_reason(ClientEvent::Kind why) {
  using enum ClientEvent::Kind;
  if (why == Withdrawn) return EndReason::Withdrawn;
  if (why == Displaced) return EndReason::Displaced;
  if (why == Revoked) return EndReason::Revoked;
  if (why == Expired) return EndReason::Expired;
  return std::nullopt;
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
  now_ = std::max(now_, now);
  while (!spent_.empty() && spent_.front().until < now_) spent_.pop_front();
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
  // Anybody can see the public key of a hello and send it under another key.
  const auto known = std::ranges::find_if(sessions_, [&](const ClientSession& session) {
    return session.hello() == hello.client && session.key() == hello.key;
  });
  if (known != sessions_.end()) {
    ++counters_.repeated;
    answer.assign(known->accept_datagram().begin(), known->accept_datagram().end());
    return;
  }
  const auto spent = std::ranges::find_if(
      spent_, [&](const SpentHello& old) { return old.client == hello.client && old.key == hello.key; });
  if (spent != spent_.end()) {
    ++counters_.repeated;
    answer = spent->answer;
    return;
  }
  if (newcomers_ == Newcomers::Ignored) {
    ++counters_.ignored;
    return;
  }
  KeyAccount& account = ledger_.of(hello.key);
  if (!gate_.may_shake_hands(account.handshakes, now)) {
    events_.push_back({ClientEvent::Kind::TooManyHandshakes, key->name, from, {}, hello.key});
    return;
  }
  const bool is_full = sessions_.size() == limits_.sessions;
  const ClientSession* const displaced = is_full ? to_displace(hello.key) : nullptr;
  const bool has_room = !is_full || displaced != nullptr, key_full = is_key_full(*key, from, now);
  const std::optional<RefusalReason> refused = why_refused(hello, key_full, has_room);
  const ServerMessage message =
      refused ? ServerMessage(Refusal{*refused, served_.scene_hash}) : ServerMessage(served_);
  const std::optional<Accepted> accepted = accept(hello, datagram, *key, message);
  if (!accepted) return;
  answer = accepted->datagram;
  const bool by_key = key_full && refused == RefusalReason::Busy;
  events_.push_back({by_key ? ClientEvent::Kind::TooManySessions : kind_of(refused, hello.scene_hash),
                     key->name,
                     from,
                     {},
                     hello.key});
  if (refused) return remember(hello.key, hello.client, answer);
  if (displaced != nullptr) end_displaced(displaced->id());
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
  else if (room_for(hello.key) < kSession_bytes)
    ++counters_.over_memory;
  else
    return std::nullopt;
  return RefusalReason::Busy;
}

void Sessions::begin_session(const SharedKey& key, const Peer& client, const Hello& hello,
                             const Accepted& accepted, Time now) {
  ++counters_.welcomed;
  sessions_.emplace_back(key, client, hello.client, accepted, now, limits_up_to(limits_.bytes_per_second),
                         served_);
  if (key.limits.bytes_per_second) share_limits();
  sessions_.back().turn = {ledger_.of(hello.key).session_work, turns_.jobs()};
  hold(sessions_.back(), 0);
  place_of_[sessions_.back().id().value] = sessions_.size() - 1;
  const Time end = end_of(sessions_.back()) + Duration(1);
  silent_at_ = silent_at_ ? std::min(*silent_at_, end) : end;
}

void Sessions::log_refusal(const Peer& from, const Hello& hello, const GateCounters& before) {
  if (gate_.counters().unknown_key != before.unknown_key)
    events_.push_back({ClientEvent::Kind::NotAdmitted, explain(hello.key, gate_.ring(), from), from});
  if (gate_.counters().expired_key != before.expired_key)
    events_.push_back(
        {ClientEvent::Kind::KeyExpired, gate_.expired().at(hello.key).name, from, {}, hello.key});
}

void Sessions::remember(const KeyId& key, const PublicKey& client, const std::vector<std::byte>& answer) {
  if (spent_.size() == kMostSpentHellos) spent_.pop_front();
  spent_.push_back({key, client, answer, now_ + kCookieLife});
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

void Sessions::end_left(SessionId id) {
  counters_.left +=
      end_sessions(ClientEvent::Kind::Left, [&](const ClientSession& session) { return session.id() == id; });
}

void Sessions::queue_goodbye(ClientSession& session, EndReason reason) {
  const std::size_t before = session.bytes();
  Farewell& farewell = farewells_.emplace_back(Farewell{session.client(), {}});
  for (int i = 0; i < kGoodbyes; ++i) session.seal_goodbye(reason, farewell.datagrams.emplace_back());
  hold(session, before);
  due_at_.reset();
}

void Sessions::say_goodbye() {
  for (ClientSession& session : sessions_) queue_goodbye(session, EndReason::ServerEnds);
}

std::optional<Time> Sessions::goodbye_at() const {
  if (farewells_.empty()) return std::nullopt;
  return std::ranges::min(farewells_, {}, &Farewell::due).due;
}

void Sessions::forgive(Duration stall, Time now) {
  for (ClientSession& session : sessions_) session.forgive(stall, now);
  silent_at_ = now;  // to be found anew
}

Decoded<void> Sessions::handle_sealed(const Peer& from, const Sealed& sealed,
                                      std::span<const std::byte> datagram, Time now,
                                      std::vector<std::byte>& answer) {
  ClientSession* const session = find(sealed.session);
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
      session->receive(from, sealed, datagram, now, answer, room_for(session->key()));
  hold(*session, before);
  if (session->client() != client_before) ++counters_.moved;
  if (session->got_false_report() && !got_false_report) ++counters_.false_reports;
  if (session->black_holes() > holes_before) ++counters_.black_holes;
  if (session->most_datagram_bytes() > carried_before) ++counters_.widened;
  if (received == ReceivedMessage::Left) {
    end_left(sealed.session);
    return {};
  }
  if (received == ReceivedMessage::NewRequest || received == ReceivedMessage::Superseded)
    turns_.was_active(session->key(), now);
  if (first && session->is_confirmed()) {
    end_replaced(sealed.session);
    end_beyond_limit(sealed.session);
  }
  if (!received) return refuse(received.error());
  was_opened_ = true;
  count(*received);
  return {};
}

void Sessions::count(ReceivedMessage received) {
  if (received == ReceivedMessage::Stray) ++counters_.stray;
  if (received == ReceivedMessage::OverMemory) ++counters_.over_memory;
  if (received == ReceivedMessage::Stray || received == ReceivedMessage::Part ||
      received == ReceivedMessage::OverMemory)
    return;
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

/// Sessions may have been let in beyond the limit of their key. Those that have been silent longest end.
void Sessions::end_beyond_limit(SessionId kept) {
  const KeyId key = find(kept)->key();
  const auto entry = gate_.ring().find(key);
  if (entry == gate_.ring().end() || !entry->second.limits.sessions) return;
  const auto is_of_key = [&](const ClientSession& session) { return session.key() == key; };
  while (static_cast<std::uint64_t>(std::ranges::count_if(sessions_, is_of_key)) >
         *entry->second.limits.sessions) {
    const ClientSession* silent = nullptr;
    for (const ClientSession& session : sessions_)
      if (is_of_key(session) && session.id() != kept &&
          (silent == nullptr || session.last_received() < silent->last_received()))
        silent = &session;
    counters_.replaced +=
        end_sessions(ClientEvent::Kind::Replaced,
                     [id = silent->id()](const ClientSession& session) { return session.id() == id; });
  }
}

template <class IsOver>
std::uint64_t Sessions::end_sessions(ClientEvent::Kind why, const IsOver& is_over) {
  const std::optional<EndReason> told = told_reason(why);
  for (ClientSession& session : sessions_)
    if (told && is_over(session)) queue_goodbye(session, *told);
  const std::uint64_t ended = std::erase_if(sessions_, [&](const ClientSession& session) {
    if (!is_over(session)) return false;
    const bool goes = why == ClientEvent::Kind::Left || why == ClientEvent::Kind::FellSilent;
    const bool said_nothing = goes && !session.has_requested();
    events_.push_back({said_nothing ? ClientEvent::Kind::SaidNothing : why, session.name(), session.client(),
                       session.last_received() - session.began(), session.key()});
    hold(session.key(), 0, session.bytes());
    // A silent one has outlived its cookies.
    if (why != ClientEvent::Kind::FellSilent) remember(session.key(), session.hello(), {});
    return true;
  });
  if (ended == 0) return 0;
  due_at_.reset();
  place_of_.clear();
  for (std::size_t i = 0; i < sessions_.size(); ++i) place_of_[sessions_[i].id().value] = i;
  share_limits();
  return ended;
}

/// Gives each session its part of its key's limit of bytes a second: the sessions of a key have equal parts.
void Sessions::share_limits() {
  std::map<KeyId, std::size_t> sessions;
  for (const ClientSession& session : sessions_) ++sessions[session.key()];
  for (ClientSession& session : sessions_) {
    const auto key = gate_.ring().find(session.key());
    if (key == gate_.ring().end()) continue;  // it is about to end
    double most = limits_.bytes_per_second;
    if (const auto& together = key->second.limits.bytes_per_second)
      most = std::min(most, static_cast<double>(*together) / static_cast<double>(sessions.at(session.key())));
    session.limit(limits_up_to(most));
  }
}

void Sessions::offer(AnswerSet answers) {
  served_.answers = answers;
  counters_.withdrawn += end_sessions(ClientEvent::Kind::Withdrawn, [&](const ClientSession& session) {
    return !session.requested_answer() || (set_of(*session.requested_answer()) & answers) == 0;
  });
  for (ClientSession& session : sessions_) session.offer(answers);
}

void Sessions::set_ring(const std::vector<SharedKey>& ring, std::chrono::sys_days today) {
  gate_.set_ring(ring, today);
  held_beyond_bytes_ = ledger_.held_beyond(limits_.memory.guaranteed(gate_.ring().size()));
  counters_.expired += end_sessions(ClientEvent::Kind::Expired, [&](const ClientSession& session) {
    return gate_.expired().contains(session.key());
  });
  counters_.revoked += end_sessions(ClientEvent::Kind::Revoked, [&](const ClientSession& session) {
    return !gate_.ring().contains(session.key());
  });
  ledger_.keep(gate_.ring());
  turns_.keep(gate_.ring());
  share_limits();
}

/// The session whose request is answered now; null if there is none.
ClientSession* Sessions::next_session(Time now) {
  turns_.look(now);
  ClientSession *next = nullptr, *held = nullptr;
  const auto order = [&](const ClientSession& session) {
    return std::pair(turns_.order(session.key()), session.turn);
  };
  for (ClientSession& session : sessions_) {
    if (!session.is_ready(now)) continue;
    session.turn.work = std::max(session.turn.work, ledger_.of(session.key()).session_work);
    ClientSession*& least = turns_.is_held(session.key(), now) ? held : next;
    if (least == nullptr || order(session) < order(*least)) least = &session;
  }
  if (next == nullptr && held != nullptr) turns_.wait_for_others(held->key(), now);
  return next;
}

std::optional<Job> Sessions::next_job(Time now) {
  ClientSession* const next = next_session(now);
  if (next == nullptr) return std::nullopt;
  ledger_.of(next->key()).session_work = next->turn.work;
  next->turn.served = turns_.begin(next->key());
  const std::size_t before = next->bytes();
  Job job = next->take_job();
  hold(*next, before);
  in_work_ = {next->id(), next->key(), size_of(job.request), now};
  job.is_too_costly = is_too_costly(*in_work_);
  if (job.is_too_costly) {
    ++counters_.too_costly;
    turns_.costs(next->key()).was_refused(in_work_->size, now);
  }
  if (answer_bytes(job.request, served_.light_count) > limits_.memory.in_work()) {
    job.is_too_costly = true;
    ++counters_.over_memory;
  }
  return job;
}

bool Sessions::is_too_costly(const InWork& job) {
  if (job.size.is_usual || turns_.costs(job.key).estimate(job.size) <= kMostTurn) return false;
  return std::ranges::any_of(sessions_, [&](const ClientSession& session) {
    return session.key() != job.key && job.begun - session.last_received() <= kPresent;
  });
}

bool Sessions::gives_up(Time now) const {
  if (!in_work_) return false;
  if (!place_of_.contains(in_work_->session.value)) return true;
  if (in_work_->size.is_usual || now - in_work_->begun <= kMostTurn) return false;
  return std::ranges::any_of(sessions_, [&](const ClientSession& session) {
    return session.key() != in_work_->key && session.is_ready(now);
  });
}

void Sessions::put(SessionId id, std::vector<std::vector<std::byte>> messages, Duration taken, Time now,
                   JobEnd end) {
  const Duration work = std::min(taken, kMostCharged);
  ClientSession* const session = find(id);
  const bool is_in_work = in_work_ && in_work_->session == id;
  if (is_in_work && gate_.ring().contains(in_work_->key)) charge(work, now, end);
  if (session == nullptr) return;
  session->turn.work += work;
  due_at_.reset();
  std::size_t bytes = 0;
  for (const std::vector<std::byte>& message : messages) bytes += message.capacity() + kMessage_bytes;
  if (bytes > room_for(session->key())) {  // only the report is sent
    ++counters_.over_memory;
    messages.erase(messages.begin(), messages.end() - 1);
    end = JobEnd::GivenUp;
  }
  const std::uint64_t slowed_before = session->held_back(), overtaken_before = session->overtaken();
  const std::size_t bytes_before = session->bytes();
  session->put(std::move(messages), now, end);
  hold(*session, bytes_before);
  counters_.held_back += session->held_back() - slowed_before;
  counters_.overtaken += session->overtaken() - overtaken_before;
}

/// What the sessions of `key` may take in addition: what is left of its own, and of what all keys share.
std::size_t Sessions::room_for(const KeyId& key) {
  const std::size_t keys = gate_.ring().size(), held = ledger_.of(key).held_bytes,
                    own = limits_.memory.guaranteed(keys),
                    shared = beyond(limits_.memory.waiting(), own * std::max<std::size_t>(keys, 1));
  return std::min(beyond(limits_.memory.of_key(keys), held),
                  beyond(own, held) + beyond(shared, held_beyond_bytes_));
}

/// Accounts what `session` holds instead of the `before` bytes that it held.
void Sessions::hold(const ClientSession& session, std::size_t before) {
  hold(session.key(), session.bytes(), before);
}

void Sessions::hold(const KeyId& key, std::size_t now, std::size_t before) {
  const std::size_t own = limits_.memory.guaranteed(gate_.ring().size());
  std::size_t& held = ledger_.of(key).held_bytes;
  held_beyond_bytes_ -= beyond(held, own);
  held += now - before;
  held_bytes_ += now - before;
  held_beyond_bytes_ += beyond(held, own);
}

/// The key owes the work of the job in work, even if its session has ended.
void Sessions::charge(Duration work, Time now, JobEnd end) {
  for (const ClientSession& session : sessions_)
    if (session.is_ready(now)) turns_.was_active(session.key(), now);
  turns_.end(in_work_->key, work, now);
  JobCosts& costs = turns_.costs(in_work_->key);
  if (end == JobEnd::Answered)
    costs.took(in_work_->size, work);
  else if (work > kMostTurn)
    costs.was_given_up(in_work_->size, work);
}

bool Sessions::seal_due(Time now, Peer& to, std::vector<std::byte>& datagram) {
  const auto is_due = [&](const Farewell& farewell) { return farewell.due <= now; };
  if (const auto next = std::ranges::find_if(farewells_, is_due); next != farewells_.end()) {
    to = next->to;
    datagram = std::move(next->datagrams.back());
    next->datagrams.pop_back();
    next->due = now + kBetweenGoodbyes;
    if (next->datagrams.empty()) farewells_.erase(next);
    due_at_.reset();
    return true;
  }
  if (const std::optional<Time> due = due_at(); !due || *due > now) return false;
  ClientSession* next = nullptr;
  const auto order = [&](const ClientSession& session) {
    return std::pair(ledger_.of(session.key()).sent_bytes, *session.due());
  };
  for (ClientSession& session : sessions_) {
    if (!session.due() || *session.due() > now) continue;
    KeyAccount& account = ledger_.of(session.key());
    account.sent_bytes = std::max(account.sent_bytes, sent_);
    if (next == nullptr || order(session) < order(*next)) next = &session;
  }
  check(next != nullptr, "a datagram is due");
  due_at_.reset();
  to = next->client();
  const std::size_t before = next->bytes();
  next->seal_due(now, datagram);
  hold(*next, before);
  KeyAccount& account = ledger_.of(next->key());
  sent_ = account.sent_bytes;
  account.sent_bytes += datagram.size();
  may_send_at_ =
      std::max(may_send_at_, now - kBurst) +
      duration_from_ms(1e3 * static_cast<double>(datagram.size()) / limits_.total_bytes_per_second);
  return true;
}

std::optional<Time> Sessions::job_at() const {
  std::optional<Time> earliest;
  for (const ClientSession& session : sessions_)
    if (std::optional<Time> at = session.ready_at()) {
      at = std::max(*at, turns_.look_at(session.key()).value_or(*at));
      if (!earliest || *at < *earliest) earliest = at;
    }
  return earliest;
}

std::optional<Time> Sessions::due_at() const {
  if (due_at_) return *due_at_;
  std::optional<Time> earliest;
  for (const ClientSession& session : sessions_)
    if (const std::optional<Time> at = session.due(); at && (!earliest || *at < *earliest)) earliest = at;
  if (earliest) earliest = std::max(*earliest, may_send_at_);
  if (const std::optional<Time> at = goodbye_at(); at && (!earliest || *at < *earliest)) earliest = at;
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
  counters_.forgotten += end_sessions(ClientEvent::Kind::FellSilent,
                                      [&](const ClientSession& session) { return now > end_of(session); });
  silent_at_.reset();
  for (const ClientSession& session : sessions_)
    if (const Time end = end_of(session) + Duration(1); !silent_at_ || end < *silent_at_) silent_at_ = end;
}

}  // namespace farshade
