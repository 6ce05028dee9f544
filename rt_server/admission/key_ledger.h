/// KeyLedger: what the holder of each key has used of the server, whatever its sessions do. Sessions begin
/// and end as their clients like; the account of a key stays for as long as the ring has the key. So a client
/// that connects anew keeps its debt, and a hundred sessions of one key have the turns of one client. A value
/// without clocks.
#pragma once

#include <map>
#include <utility>

#include "rt_server/admission/token_bucket.h"
#include "stereo/sealing/key_file.h"

namespace farshade {

/// The handshakes that a key may begin. Half of those of the server are divided among the keys, so that other
/// keys, however many work together, cannot take them; the other half goes to whoever comes first, but a key
/// of several has at most half of all.
struct KeyHandshakes {
  KeyHandshakes(double per_second, std::size_t keys)
      : own(keys > 1 ? 0.5 * per_second / static_cast<double>(keys) : per_second),
        all(keys > 1 ? 0.5 * per_second : per_second) {}
  TokenBucket own, all;
};

struct KeyAccount {
  KeyAccount(double handshakes_per_second, std::size_t keys) : handshakes(handshakes_per_second, keys) {}

  /// Sealed datagrams of its answers. A key that had nothing to do starts again at the value of the others.
  std::uint64_t sent_bytes = 0;
  Duration session_work{};  ///< ClientSession::Turn::work of its session that was served last
  KeyHandshakes handshakes;
  std::size_t held_bytes = 0;  ///< memory of its sessions
};

/// The part of `held` that is more than `guaranteed`.
[[nodiscard]] constexpr std::size_t beyond(std::size_t held, std::size_t guaranteed) {
  return held - std::min(held, guaranteed);
}

class KeyLedger {
 public:
  explicit KeyLedger(double handshakes_per_second) : handshakes_per_second_(handshakes_per_second) {}

  /// The accounts of keys that are not in `ring` end.
  void keep(const KeyRing& ring) {
    std::erase_if(accounts_, [&](const auto& entry) { return !ring.contains(entry.first); });
    if (ring.size() == std::exchange(keys_, ring.size())) return;
    for (auto& [key, account] : accounts_) account.handshakes = {handshakes_per_second_, keys_};
  }

  /// The sum of what keys hold beyond `guaranteed` each.
  [[nodiscard]] std::size_t held_beyond(std::size_t guaranteed) const {
    std::size_t sum = 0;
    for (const auto& [key, account] : accounts_) sum += beyond(account.held_bytes, guaranteed);
    return sum;
  }

  /// The account of a key of the ring; a new one begins with nothing used.
  [[nodiscard]] KeyAccount& of(const KeyId& key) {
    return accounts_.try_emplace(key, handshakes_per_second_, keys_).first->second;
  }

 private:
  double handshakes_per_second_;
  std::size_t keys_ = 1;
  std::map<KeyId, KeyAccount> accounts_;
};

}  // namespace farshade
