/// Recent: a small LRU cache.
#pragma once

#include <algorithm>
#include <cstddef>
#include <list>
#include <utility>

namespace farshade {

template <class Key, class Value>
class Recent {
 public:
  explicit Recent(std::size_t capacity) : capacity_(capacity) {}

  /// Null if there is no value for `key`. The value becomes the most recently used.
  Value* find(const Key& key) {
    const auto found = std::ranges::find(kept_, key, &Kept::first);
    if (found == kept_.end()) return nullptr;
    kept_.splice(kept_.begin(), kept_, found);
    return &kept_.front().second;
  }

  /// Replaces a value with the same key. Otherwise evicts the least recently used value if the cache is full.
  Value& put(const Key& key, Value value) {
    std::erase_if(kept_, [&](const Kept& entry) { return entry.first == key; });
    if (kept_.size() == capacity_) kept_.pop_back();
    kept_.emplace_front(key, std::move(value));
    return kept_.front().second;
  }

 private:
  using Kept = std::pair<Key, Value>;
  std::size_t capacity_;
  std::list<Kept> kept_;  ///< most recently used first
};

}  // namespace farshade
