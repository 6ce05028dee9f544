/// The version of the protocol: which layout the messages have. It stands in every envelope. The upper 6 bits
/// are a number, which grows with each change; the lower 10 are of a hash of all layouts
/// (stereo/sealing/layout.h), so that programs of different layouts refuse each other even if somebody forgot
/// the number. Versions up to 10 are the number alone.
#pragma once

#include <cstdint>

namespace farshade {

using ProtocolVersion = std::uint16_t;

inline constexpr unsigned kProtocolNumber = 11;
inline constexpr unsigned kLayoutHash = 117;  ///< check_layout() prints the right one
inline constexpr ProtocolVersion kProtocolVersion = kProtocolNumber << 10 | kLayoutHash;
/// Servers also accept clients of this version, and answer them in it. It has the same layout.
inline constexpr ProtocolVersion kPreviousVersion = 10;

[[nodiscard]] constexpr bool is_spoken(ProtocolVersion version) {
  return version == kProtocolVersion || version == kPreviousVersion;
}

[[nodiscard]] constexpr unsigned number_of(ProtocolVersion version) {
  return version <= 10 ? version : version >> 10;
}

}  // namespace farshade
