/// FairLruCache: a small cache of what is dear to make, shared by the clients of all keys. What one key makes
/// anew costs the others nothing that they have: when there is no room, the key with the most loses its least
/// recently used value, and a key that makes another one and has as many loses its own.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <list>
#include <map>
#include <utility>

#include "stereo/sealing/key_file.h"

namespace farshade {

template <class Key, class Value>
class FairLruCache {
 public:
  /// Keeps `most` values of `most_bytes` in all.
  FairLruCache(std::size_t most, std::size_t most_bytes) : most_(most), most_bytes_(most_bytes) {}

  /// Null if there is no value for `key`. The value becomes the most recently used.
  Value* find(const Key& key) {
    const auto found = std::ranges::find(kept_, key, &Kept::key);
    if (found == kept_.end()) return nullptr;
    kept_.splice(kept_.begin(), kept_, found);
    return &kept_.front().value;
  }

  /// Removes the value of `key`, and others until one of `bytes` has room.
  void make_room(const Key& key, const KeyId& owner, std::size_t bytes) {
    std::erase_if(kept_, [&](const Kept& entry) { return entry.key == key; });
    const auto held = [&] {
      std::size_t sum = bytes;
      for (const Kept& entry : kept_) sum += entry.bytes;
      return sum;
    };
    while (!kept_.empty() && (kept_.size() >= most_ || held() > most_bytes_)) kept_.erase(to_lose(owner));
  }

  /// Replaces a value with the same key. `owner`: the key whose client needs the value.
  Value& put(const Key& key, const KeyId& owner, std::size_t bytes, Value value) {
    make_room(key, owner, bytes);
    kept_.push_front({key, owner, bytes, std::move(value)});
    return kept_.front().value;
  }

 private:
  struct Kept {
    Key key;
    KeyId owner;
    std::size_t bytes;
    Value value;
  };

  auto to_lose(const KeyId& newcomer) {
    std::map<KeyId, std::size_t> values_of;
    for (const Kept& entry : kept_) ++values_of[entry.owner];
    std::size_t most = 0;
    for (const auto& [holder, values] : values_of) most = std::max(most, values);
    const bool own = values_of[newcomer] == most;
    auto entry = std::prev(kept_.end());
    while (own ? entry->owner != newcomer : values_of[entry->owner] != most) --entry;
    return entry;
  }

  std::size_t most_, most_bytes_;
  std::list<Kept> kept_;  ///< most recently used first
};

}  // namespace farshade
