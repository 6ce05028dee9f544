/// WatchedSodium: records the calls of sodium_memzero and sodium_memcmp. The test program defines both
/// itself, and they come before those of a shared libsodium.
#pragma once

#include <cstddef>
#include <vector>

namespace farshade {

/// Records the calls of this thread while it lives. One of them at a time.
class WatchedSodium {
 public:
  WatchedSodium();
  WatchedSodium(const WatchedSodium&) = delete;
  WatchedSodium& operator=(const WatchedSodium&) = delete;
  ~WatchedSodium();

  /// False with a static libsodium: then nothing is recorded.
  static bool is_possible();

  std::vector<std::size_t> wiped, compared;  ///< the number of bytes of each call, in their order
};

}  // namespace farshade
