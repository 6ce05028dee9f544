#include "rt_server/sessions/session_table.h"

#include <algorithm>
#include <map>
#include <utility>

namespace farshade {

ClientSession* SessionTable::find(SessionId id) {
  const auto found = place_of_.find(id.value);
  return found == place_of_.end() ? nullptr : &sessions_[found->second];
}

const ClientSession* SessionTable::find(const Hello& hello) const {
  // Anybody can see the public key of a hello and send it under another key.
  const auto known = std::ranges::find_if(sessions_, [&](const ClientSession& session) {
    return session.hello() == hello.client && session.key() == hello.key;
  });
  return known == sessions_.end() ? nullptr : &*known;
}

const ClientSession* SessionTable::to_displace(const KeyId& newcomer) const {
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

const ClientSession* SessionTable::beyond_limit(const KeyId& key, std::uint64_t most, SessionId kept) const {
  std::uint64_t number = 0;
  const ClientSession* silent = nullptr;
  for (const ClientSession& session : sessions_) {
    if (session.key() != key) continue;
    ++number;
    if (session.id() != kept && (silent == nullptr || session.last_received() < silent->last_received()))
      silent = &session;
  }
  return number > most ? silent : nullptr;
}

ClientSession& SessionTable::add(ClientSession session) {
  place_of_[session.id().value] = sessions_.size();
  const Time end = end_of(session) + Duration(1);
  silent_at_ = silent_at_ ? std::min(*silent_at_, end) : end;
  return sessions_.emplace_back(std::move(session));
}

void SessionTable::find_places() {
  place_of_.clear();
  for (std::size_t i = 0; i < sessions_.size(); ++i) place_of_[sessions_[i].id().value] = i;
}

void SessionTable::find_silent_at() {
  silent_at_.reset();
  for (const ClientSession& session : sessions_)
    if (const Time end = end_of(session) + Duration(1); !silent_at_ || end < *silent_at_) silent_at_ = end;
}

void SessionTable::share_limits(const KeyRing& ring, double bytes_per_second) {
  std::map<KeyId, std::size_t> sessions;
  for (const ClientSession& session : sessions_) ++sessions[session.key()];
  for (ClientSession& session : sessions_) {
    const auto key = ring.find(session.key());
    if (key == ring.end()) continue;  // it is about to end
    double most = bytes_per_second;
    if (const auto& together = key->second.limits.bytes_per_second)
      most = std::min(most, static_cast<double>(*together) / static_cast<double>(sessions.at(session.key())));
    session.limit(limits_up_to(most));
  }
}

void SessionTable::forgive(Duration stall, Time now) {
  for (ClientSession& session : sessions_) session.forgive(stall, now);
  silent_at_ = now;  // to be found anew
}

}  // namespace farshade
