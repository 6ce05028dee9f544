/// WriteOnly: a view of memory that the program writes and never reads. A GPU's memory that the processor
/// sees is often write-combined: a read of it takes hundreds of times as long as one of ordinary memory. So
/// there is no way to read through the view. Writes are fastest in order and of whole words.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "stereo/base/check.h"

namespace farshade {

template <class T>
class WriteOnly {
  static_assert(std::is_trivially_copyable_v<T> && !std::is_const_v<T>);

 public:
  WriteOnly() = default;
  explicit WriteOnly(std::span<T> memory) : memory_(memory) {}

  [[nodiscard]] std::size_t size() const { return memory_.size(); }
  [[nodiscard]] WriteOnly part(std::size_t first, std::size_t count) const {
    check(first <= size() && count <= size() - first, "a part lies in its view");
    return WriteOnly(memory_.subspan(first, count));
  }
  /// The same memory as elements of `U`. Bytes that are no whole element are left out.
  template <class U>
  [[nodiscard]] WriteOnly<U> as() const {
    auto* const first = reinterpret_cast<U*>(memory_.data());
    check(reinterpret_cast<std::uintptr_t>(first) % alignof(U) == 0, "a view is aligned to its elements");
    return WriteOnly<U>(std::span<U>(first, memory_.size_bytes() / sizeof(U)));
  }

  void write(std::size_t i, const T& value) const {
    check(i < size(), "an element lies in its view");
    memory_[i] = value;
  }
  /// Writes the first elements.
  void copy(std::span<const T> values) const {
    check(values.size() <= size(), "the values fit the view");
    std::ranges::copy(values, memory_.begin());
  }
  void fill(const T& value) const { std::ranges::fill(memory_, value); }
  /// Sets each element i to value_of(i), in order.
  template <class ValueOf>
  void generate(ValueOf value_of) const {
    T* const memory = memory_.data();
    const std::size_t count = memory_.size();
    for (std::size_t i = 0; i < count; ++i) memory[i] = value_of(i);
  }

 private:
  std::span<T> memory_;
};

}  // namespace farshade
