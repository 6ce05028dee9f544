/// KeyLedger: what the holder of each key has used of the server, whatever its sessions do. Sessions begin
/// and end as their clients like; the account of a key stays for as long as the ring has the key. So a client
/// that connects anew keeps its debt, and a hundred sessions of one key have the turns of one client. A value
/// without clocks.
#pragma once

#include <map>
#include <utility>

#include "rt_server/core/job_costs.h"
#include "rt_server/core/token_bucket.h"
#include "stereo/wire/key_file.h"

namespace farshade {

struct KeyAccount {
  explicit KeyAccount(double handshakes_per_second) : handshakes(handshakes_per_second) {}

  /// Time of the worker. A key that had nothing to do starts again at the value of the others.
  Duration work{};
  std::uint64_t served = 0;      ///< number of jobs of all clients when this key was last served
  std::uint64_t sent_bytes = 0;  ///< sealed datagrams of its answers, counted like `work`
  Duration session_work{};       ///< ClientSession::Turn::work of its session that was served last
  TokenBucket handshakes;
  std::size_t held_bytes = 0;  ///< memory of its sessions
  JobCosts costs;
};

class KeyLedger {
 public:
  explicit KeyLedger(double handshakes_per_second) : handshakes_per_second_(handshakes_per_second) {}

  /// The accounts of keys that are not in `ring` end. One key of several has at most half of the handshakes.
  void keep(const KeyRing& ring) {
    std::erase_if(accounts_, [&](const auto& entry) { return !ring.contains(entry.first); });
    const double share = ring.size() > 1 ? 0.5 : 1;
    if (share == std::exchange(share_, share)) return;
    for (auto& [key, account] : accounts_) account.handshakes = TokenBucket(share * handshakes_per_second_);
  }

  /// The account of a key of the ring; a new one begins with nothing used.
  [[nodiscard]] KeyAccount& of(const KeyId& key) {
    return accounts_.try_emplace(key, share_ * handshakes_per_second_).first->second;
  }

 private:
  double handshakes_per_second_, share_ = 1;
  std::map<KeyId, KeyAccount> accounts_;
};

}  // namespace farshade
