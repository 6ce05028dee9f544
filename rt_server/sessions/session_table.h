/// SessionTable: the sessions that exist. Finds one by its id, so that the cost of a stranger's datagram does
/// not grow with their number, and knows which of them has been silent for too long.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "rt_server/sessions/session.h"

namespace farshade {

class SessionTable {
 public:
  /// A session ends after `silence`; until its first sealed datagram has arrived, after `unconfirmed`.
  SessionTable(Duration silence, Duration unconfirmed) : silence_(silence), unconfirmed_(unconfirmed) {}

  [[nodiscard]] auto begin() { return sessions_.begin(); }
  [[nodiscard]] auto end() { return sessions_.end(); }
  [[nodiscard]] auto begin() const { return sessions_.begin(); }
  [[nodiscard]] auto end() const { return sessions_.end(); }
  [[nodiscard]] std::size_t size() const { return sessions_.size(); }
  void reserve(std::size_t sessions) { sessions_.reserve(sessions); }

  /// Null if there is no session with this id, or none that this hello of its key began.
  [[nodiscard]] ClientSession* find(SessionId id);
  [[nodiscard]] const ClientSession* find(const Hello& hello) const;
  [[nodiscard]] bool contains(SessionId id) const { return place_of_.contains(id.value); }
  /// When the table is full: the newest session of the key with the most, if the newcomer's key then has no
  /// more than that key. Null if the newcomer must wait.
  [[nodiscard]] const ClientSession* to_displace(const KeyId& newcomer) const;
  /// Of the sessions of `key`, the one that has been silent longest, if there are more than `most`. Never
  /// `kept`.
  [[nodiscard]] const ClientSession* beyond_limit(const KeyId& key, std::uint64_t most, SessionId kept) const;

  ClientSession& add(ClientSession session);
  /// Removes the sessions for which `is_over`, which is called once for each, and returns their number.
  template <class IsOver>
  std::size_t erase_if(const IsOver& is_over) {
    const std::size_t erased = std::erase_if(sessions_, is_over);
    if (erased > 0) find_places();
    return erased;
  }

  /// Gives each session its part of the limit that its key has in `ring`: the sessions of a key have equal
  /// parts. None may send more than `bytes_per_second`.
  void share_limits(const KeyRing& ring, double bytes_per_second);

  /// When a session may have been silent for too long: not after the first of them ends.
  [[nodiscard]] std::optional<Time> silent_at() const { return silent_at_; }
  [[nodiscard]] bool is_silent(const ClientSession& session, Time now) const { return now > end_of(session); }
  /// Finds silent_at() anew, after the silent sessions were removed.
  void find_silent_at();
  /// The server did not run for the `stall` before `now`: its clients were not silent.
  void forgive(Duration stall, Time now);

 private:
  void find_places();
  [[nodiscard]] Time end_of(const ClientSession& session) const {
    return session.last_received() + (session.is_confirmed() ? silence_ : unconfirmed_);
  }

  Duration silence_, unconfirmed_;
  std::vector<ClientSession> sessions_;
  std::unordered_map<std::uint64_t, std::size_t> place_of_;  ///< in sessions_, by SessionId
  std::optional<Time> silent_at_;
};

}  // namespace farshade
