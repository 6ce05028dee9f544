/// Recent: a few values by key, made when first asked for; the one that was longest not asked for makes room.
#pragma once

#include <algorithm>
#include <cstddef>
#include <list>
#include <utility>

namespace farshade {

template <class Key, class Value>
class Recent {
 public:
  explicit Recent(std::size_t most) : most_(most) {}

  /// Null if there is none.
  Value* find(const Key& key) {
    const auto found = std::ranges::find(kept_, key, &Kept::first);
    if (found == kept_.end()) return nullptr;
    kept_.splice(kept_.begin(), kept_, found);
    return &kept_.front().second;
  }

  /// Takes the place of one of the same key.
  Value& put(const Key& key, Value value) {
    std::erase_if(kept_, [&](const Kept& one) { return one.first == key; });
    if (kept_.size() == most_) kept_.pop_back();
    kept_.emplace_front(key, std::move(value));
    return kept_.front().second;
  }

 private:
  using Kept = std::pair<Key, Value>;
  std::size_t most_;
  std::list<Kept> kept_;  ///< latest first
};

}  // namespace farshade
