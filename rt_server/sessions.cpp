#include "rt_server/sessions.h"

#include <algorithm>

namespace farshade {

Sessions::Sessions(const Welcome& served, SessionLimits limits) : served_(served), limits_(limits) {
  sessions_.reserve(limits.sessions);
}

std::optional<ServerMessage> Sessions::handle(const Peer& client, const ClientMessage& message, Time now) {
  forget_silent(now);
  if (const auto* hello = std::get_if<Hello>(&message)) return greet(client, *hello, now);
  return take(client, std::get<RequestMessage>(message), now);
}

std::optional<ServerMessage> Sessions::greet(const Peer& client, const Hello& hello, Time now) {
  if (hello.version != kProtocolVersion)
    return refuse_client(RefusalReason::VersionMismatch, counters_.version_mismatch);
  if (hello.scene_hash != served_.scene_hash)
    return refuse_client(RefusalReason::SceneMismatch, counters_.scene_mismatch);
  Session* session = find(client);
  if (session == nullptr) {
    if (sessions_.size() == limits_.sessions) return refuse_client(RefusalReason::Busy, counters_.busy);
    session = &sessions_.emplace_back(Session{.client = client, .heard = now, .served = turn_});
    ++counters_.welcomed;
  }
  // A program that starts anew at the same address counts its frames anew.
  session->heard = now;
  session->newest.reset();
  session->waiting.reset();
  return served_;
}

std::optional<ServerMessage> Sessions::take(const Peer& client, const RequestMessage& message, Time now) {
  Session* const session = find(client);
  if (session == nullptr) return refuse_client(RefusalReason::NotWelcomed, counters_.not_welcomed);
  session->heard = now;
  ++counters_.requests;
  const FrameId frame = message.request.frame;
  if (session->newest && !is_newer(frame, *session->newest)) {
    ++counters_.outdated;
    return std::nullopt;
  }
  if (session->waiting) {
    ++session->superseded;
    ++counters_.superseded;
  }
  session->newest = frame;
  session->waiting = Job{client, message.request, now, session->superseded};
  return std::nullopt;
}

std::optional<Job> Sessions::next_job() {
  Session* next = nullptr;
  for (Session& session : sessions_)
    if (session.waiting && (next == nullptr || session.served < next->served)) next = &session;
  if (next == nullptr) return std::nullopt;
  next->served = ++turn_;
  return std::exchange(next->waiting, std::nullopt);
}

bool Sessions::has_job() const {
  return std::ranges::any_of(sessions_, [](const Session& session) { return session.waiting.has_value(); });
}

ServerMessage Sessions::refuse_client(RefusalReason reason, std::uint64_t& counter) {
  ++counter;
  return Refusal{.reason = reason, .version = kProtocolVersion, .scene_hash = served_.scene_hash};
}

Sessions::Session* Sessions::find(const Peer& client) {
  const auto found = std::ranges::find(sessions_, client, &Session::client);
  return found == sessions_.end() ? nullptr : &*found;
}

void Sessions::forget_silent(Time now) {
  counters_.forgotten +=
      std::erase_if(sessions_, [&](const Session& session) { return now - session.heard > limits_.silence; });
}

}  // namespace farshade
