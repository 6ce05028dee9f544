/// FrameId: 32-bit serial number of a request (RFC 1982 order). Never compared with `<`.
#pragma once

#include <cstdint>

namespace farshade {

struct FrameId {
  std::uint32_t value = 0;
  friend bool operator==(FrameId, FrameId) = default;
};

/// Serial order, correct across wraparound.
constexpr bool is_newer(FrameId a, FrameId b) {
  return static_cast<std::int32_t>(a.value - b.value) > 0;
}

constexpr FrameId next(FrameId id) {
  return {id.value + 1};
}

}  // namespace farshade
