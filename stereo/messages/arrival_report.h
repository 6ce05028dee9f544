/// ArrivalReport: which of the server's sealed datagrams have arrived, and when. The client puts one into
/// every request; the server's rate control (stereo/net/rate_control.h) uses it. Several reports contain the
/// same arrivals, so a lost report does no harm.
#pragma once

#include <array>
#include <cstdint>

#include "stereo/base/clock.h"

namespace farshade {

struct ArrivalReport {
  static constexpr std::size_t kMost = 256;             ///< entries
  static constexpr std::uint16_t kNotArrived = 0xffff;  ///< an entry: has not arrived (yet)
  static constexpr Duration kTick = std::chrono::microseconds(64);

  std::uint64_t first =
      0;  ///< counter (stereo/sealing/seal.h) of the first entry's datagram; the next entries are consecutive
  Time base{};                               ///< on the client's clock; nothing in the report arrived earlier
  std::uint32_t count = 0;                   ///< entries in use, at most kMost
  std::array<std::uint16_t, kMost> ticks{};  ///< arrival in ticks after `base`

  [[nodiscard]] bool arrived(std::size_t i) const { return ticks[i] != kNotArrived; }
  [[nodiscard]] Time arrival(std::size_t i) const { return base + ticks[i] * kTick; }
};

}  // namespace farshade
