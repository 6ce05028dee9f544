/// ReplayWindow: remembers which counters have been opened, as a ring of bits behind the newest one (RFC
/// 6479). It treats a counter that is older than the window as opened.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace farshade {

class ReplayWindow {
 public:
  static constexpr std::uint64_t kSize = 4096;  ///< counters in the window, including the newest
  /// A sender cannot send more datagrams than this before the other side ends the session: at 10^10 bytes per
  /// second, 83 million datagrams of 1,200 bytes in kSessionTimeout.
  static constexpr std::uint64_t kMostJump = std::uint64_t{1} << 27;
  /// No session lasts that long: at the rate above, half a year.
  static constexpr std::uint64_t kMostCounter = std::uint64_t{1} << 47;

  /// The counter is larger than a sender that counts up by one can have reached.
  [[nodiscard]] bool is_too_far(std::uint64_t counter) const {
    const std::uint64_t newest = newest_.value_or(0);
    return counter > kMostCounter || (counter > newest && counter - newest > kMostJump);
  }

  [[nodiscard]] bool is_new(std::uint64_t counter) const {
    if (!newest_ || counter > *newest_) return true;
    return *newest_ - counter < kSize && (word(counter) >> (counter % 64) & 1u) == 0;
  }

  /// Call it only for a counter that is new and whose datagram has opened.
  void take(std::uint64_t counter) {
    if (!newest_ || counter > *newest_) forget_up_to(counter);
    bits_[counter / 64 % kWords] |= std::uint64_t{1} << (counter % 64);
  }

  [[nodiscard]] std::optional<std::uint64_t> newest() const { return newest_; }

 private:
  /// One word more than the window needs: the newest counter's word never has bits of the oldest counters.
  static constexpr std::uint64_t kWords = kSize / 64 + 1;

  [[nodiscard]] std::uint64_t word(std::uint64_t counter) const { return bits_[counter / 64 % kWords]; }

  void forget_up_to(std::uint64_t counter) {
    if (newest_) {
      const std::uint64_t first = *newest_ / 64 + 1, last = counter / 64;
      if (last >= first + kWords)
        bits_.fill(0);
      else
        for (std::uint64_t w = first; w <= last; ++w) bits_[w % kWords] = 0;
    }
    newest_ = counter;
  }

  std::array<std::uint64_t, kWords> bits_{};
  std::optional<std::uint64_t> newest_;
};

}  // namespace farshade
