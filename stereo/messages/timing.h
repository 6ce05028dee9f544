/// Timing: times and counts of the protocol's flow. PROTOCOL.md, "Constants", lists them; a test compares the
/// list with these values.
#pragma once

#include <cstdint>

#include "stereo/base/clock.h"

namespace farshade {

// ---- both

/// A sender takes its next key when the one in use is older than this (stereo/sealing/seal.h).
inline constexpr Duration kEpochTime = std::chrono::seconds(120);

// ---- client

/// Time between two Hellos to a server that has not answered.
inline constexpr Duration kHelloInterval = std::chrono::milliseconds(250);
/// The client starts a second handshake if it has received nothing for this long, although it has sent
/// kLeastUnanswered requests in that time: the server may have been restarted. A silent path looks the same.
/// So the client keeps the old session until the new one has begun.
inline constexpr Duration kServerSilence = std::chrono::milliseconds(250);
/// The same after a NoSession, which anybody may have sent.
inline constexpr Duration kServerSilenceAfterNoSession = std::chrono::milliseconds(200);
inline constexpr std::uint32_t kLeastUnanswered = 4;

// ---- server

/// A client that sends requests and has been sent nothing for this long gets a Probe, so that it does not
/// take a busy server for one that was restarted. Shorter than both silences above.
inline constexpr Duration kKeepaliveInterval = std::chrono::milliseconds(100);
/// A cookie is valid in the period in which it was made and in the next one.
inline constexpr Duration kCookiePeriod = std::chrono::seconds(2);
inline constexpr Duration kCookieLife = 2 * kCookiePeriod;
/// The server ends a session after this time without a datagram that opens. Both are longer than kCookieLife,
/// so that a repeated Hello finds the session that the first one made.
inline constexpr Duration kSessionTimeout = std::chrono::seconds(10);
inline constexpr Duration kUnconfirmedTimeout = std::chrono::seconds(5);  ///< before the first such datagram
static_assert(kUnconfirmedTimeout > kCookieLife && kSessionTimeout > kCookieLife);
static_assert(kKeepaliveInterval < kServerSilenceAfterNoSession);
/// The server traces a request this long after the last of its parts that came (positions, or blocks asked
/// for), if some are missing.
inline constexpr Duration kPartsTimeout = std::chrono::milliseconds(10);

}  // namespace farshade
