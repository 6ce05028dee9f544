/// A fuzz target: one function that takes arbitrary bytes. In the preset fuzz libFuzzer calls it. In every
/// other preset replay.cpp calls it with each file of tests/fuzz/corpus/NAME. A target tests properties with
/// check(): a failed check ends the program, as a crash does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "stereo/base/check.h"

/// libFuzzer's entry point. Returns 0: libFuzzer may add the input to the corpus.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace farshade::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Reads numbers from the front of an input; 0 after its end. The remaining bytes of the input are the bytes
/// under test.
class Choices {
 public:
  Choices(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

  /// 0 to `most`.
  std::uint32_t up_to(std::uint32_t most) {
    std::uint32_t value = 0;
    for (int i = 0; i < (most < 256 ? 1 : 2) && !rest_.empty(); ++i, rest_ = rest_.subspan(1))
      value = value << 8 | rest_.front();
    return value % (most + 1);
  }
  /// The next `count` bytes, or fewer at the end.
  std::span<const std::byte> bytes(std::size_t count) {
    const auto taken = rest_.first(count < rest_.size() ? count : rest_.size());
    rest_ = rest_.subspan(taken.size());
    return std::as_bytes(taken);
  }
  [[nodiscard]] std::span<const std::byte> rest() const { return std::as_bytes(rest_); }

 private:
  std::span<const std::uint8_t> rest_;
};

}  // namespace farshade::fuzz
