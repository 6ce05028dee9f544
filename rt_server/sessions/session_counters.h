/// SessionCounters: what has happened to the sessions and requests of all clients, for the log and for tests.
#pragma once

#include <cstdint>

#include "rt_server/sessions/waiting_requests.h"

namespace farshade {

struct SessionCounters {
  std::uint64_t welcomed = 0;       ///< sessions begun
  std::uint64_t repeated = 0;       ///< hellos of sessions that exist
  std::uint64_t forgotten = 0;      ///< sessions ended by timeout
  std::uint64_t left = 0;           ///< sessions ended by their clients
  std::uint64_t replaced = 0;       ///< sessions ended by a newer one of the same key from the same address
  std::uint64_t withdrawn = 0;      ///< sessions ended because the answer they use is no longer offered
  std::uint64_t revoked = 0;        ///< sessions ended because their key was taken out of the ring
  std::uint64_t expired = 0;        ///< sessions ended because their key's time was over
  std::uint64_t displaced = 0;      ///< sessions ended for a client whose key had fewer
  std::uint64_t moved = 0;          ///< changes of a client's address
  std::uint64_t false_reports = 0;  ///< sessions that reported the arrival of what was never sent
  std::uint64_t requests = 0;       ///< requests of all sessions; the next four count some of them
  std::uint64_t superseded = 0;     ///< replaced by a newer request before they were answered
  std::uint64_t outdated = 0;       ///< not newer than an earlier request
  std::uint64_t too_large = 0;      ///< for more pixels than allowed
  std::uint64_t unanswered = 0;     ///< for an answer that the server does not offer
  std::uint64_t stray = 0;          ///< parts of requests that belong to no waiting one
  std::uint64_t over_memory = 0;    ///< sessions, parts and answers refused for the limit of memory
  std::uint64_t too_costly = 0;     ///< answered without content, because the answer would take too long
  std::uint64_t scene_mismatch = 0, busy = 0;  ///< hellos with a valid key that were refused
  std::uint64_t ignored = 0;                   ///< hellos with a valid key while nobody new is admitted
  std::uint64_t key_full = 0;                  ///< the same: their key has as many sessions as it may
  std::uint64_t held_back = 0;                 ///< frames slowed by the limit of bytes per second
  std::uint64_t overtaken = 0;                 ///< frames whose rest a newer frame replaced
  std::uint64_t widened = 0;                   ///< times that a path was found to carry larger datagrams
  std::uint64_t black_holes = 0;               ///< paths that stopped to carry large datagrams

  /// Counts a message of a session.
  void count(ReceivedMessage received) {
    using enum ReceivedMessage;
    if (received == Stray) ++stray;
    if (received == OverMemory) ++over_memory;
    if (received == Stray || received == Part || received == OverMemory) return;
    ++requests;
    if (received == Unanswered) ++unanswered;
    if (received == Superseded) ++superseded;
    if (received == Outdated) ++outdated;
    if (received == TooLarge) ++too_large;
  }
  friend bool operator==(const SessionCounters&, const SessionCounters&) = default;
};

}  // namespace farshade
