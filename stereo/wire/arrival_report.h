/// ArrivalReport: what came of the server's sealed datagrams, as the client tells it in its requests. The
/// server's rate control (stereo/net/rate_control.h) lives on it; a lost report costs nothing, the next ones
/// say it again.
#pragma once

#include <array>
#include <cstdint>

#include "stereo/base/clock.h"

namespace farshade {

struct ArrivalReport {
  static constexpr std::size_t kMost = 256;             ///< entries
  static constexpr std::uint16_t kNotArrived = 0xffff;  ///< an entry: not here (yet)
  static constexpr Duration kTick = std::chrono::microseconds(64);

  std::uint64_t first = 0;  ///< counter of the first entry's datagram (seal.h); the others follow one by one
  Time base{};              ///< on the client's clock; nothing in the report arrived earlier
  std::uint32_t count = 0;  ///< entries in use, at most kMost
  std::array<std::uint16_t, kMost>
      ticks{};  ///< arrival in ticks after `base`; what is later than that was left out

  [[nodiscard]] bool arrived(std::size_t i) const { return ticks[i] != kNotArrived; }
  [[nodiscard]] Time arrival(std::size_t i) const { return base + ticks[i] * kTick; }
};

}  // namespace farshade
