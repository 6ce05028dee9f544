/// KeyLedger: what the holder of each key has used of the server, whatever its sessions do. Sessions begin
/// and end as their clients like; the account of a key stays for as long as the ring has the key. So a client
/// that connects anew keeps its debt, and a hundred sessions of one key have the turns of one client. A value
/// without clocks.
#pragma once

#include <map>
#include <utility>

#include "rt_server/admission/memory_share.h"
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
  KeyLedger(double handshakes_per_second, const MemoryShare& memory)
      : handshakes_per_second_(handshakes_per_second), memory_(memory) {}

  /// From now on the ring is `ring`. The accounts of keys that are not in it end; their sessions have ended.
  void keep(const KeyRing& ring) {
    std::erase_if(accounts_, [&](const auto& entry) { return !ring.contains(entry.first); });
    if (ring.size() == std::exchange(keys_, ring.size())) return;
    held_beyond_bytes_ = 0;
    for (auto& [key, account] : accounts_) {
      account.handshakes = {handshakes_per_second_, keys_};
      held_beyond_bytes_ += beyond(account.held_bytes, memory_.guaranteed(keys_));
    }
  }

  /// Memory that the sessions of all keys hold.
  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_; }
  /// What the sessions of `key` may take in addition: what is left of its own, and of what all keys share.
  [[nodiscard]] std::size_t room_for(const KeyId& key) {
    const std::size_t held = of(key).held_bytes, own = memory_.guaranteed(keys_),
                      shared = beyond(memory_.waiting(), own * std::max<std::size_t>(keys_, 1));
    return std::min(beyond(memory_.of_key(keys_), held),
                    beyond(own, held) + beyond(shared, held_beyond_bytes_));
  }
  /// A session of `key` holds `now` bytes instead of the `before` that it held.
  void hold(const KeyId& key, std::size_t now, std::size_t before) {
    const std::size_t own = memory_.guaranteed(keys_);
    std::size_t& held = of(key).held_bytes;
    held_beyond_bytes_ -= beyond(held, own);
    held += now - before;
    held_bytes_ += now - before;
    held_beyond_bytes_ += beyond(held, own);
  }

  /// The account of a key of the ring; a new one begins with nothing used.
  [[nodiscard]] KeyAccount& of(const KeyId& key) {
    return accounts_.try_emplace(key, handshakes_per_second_, keys_).first->second;
  }

 private:
  double handshakes_per_second_;
  MemoryShare memory_;
  std::size_t keys_ = 1;  ///< in the ring
  std::size_t held_bytes_ = 0;
  std::size_t held_beyond_bytes_ = 0;  ///< the parts that keys hold beyond what each is guaranteed
  std::map<KeyId, KeyAccount> accounts_;
};

}  // namespace farshade
