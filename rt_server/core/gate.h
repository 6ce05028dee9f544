/// Gate: what stands before the sessions. A stranger's hello is answered with a cookie that proves its
/// address, one with a cookie is believed if it proves a key of the ring; until then nothing is kept of it,
/// and no answer is longer than it was. A value without sockets, threads or clocks.
#pragma once

#include <map>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/net/datagram.h"
#include "stereo/wire/handshake.h"

namespace farshade {

struct GateCounters {
  std::uint64_t retries = 0;           ///< hellos without a cookie that holds
  std::uint64_t version_mismatch = 0;  ///< hellos of another version
  std::uint64_t unknown_key = 0;       ///< hellos of a key that is not in the ring, or not made with it
  std::uint64_t too_many = 0;          ///< proved hellos beyond handshakes_per_second
  friend bool operator==(const GateCounters&, const GateCounters&) = default;
};

class Gate {
 public:
  /// Keys of different secrets. `handshakes_per_second`: so many are let through, and as many at once after a
  /// quiet second.
  Gate(const std::vector<SharedKey>& ring, double handshakes_per_second);

  /// The key that `hello`, read from `datagram`, has proved; it stays where it is. Else null, and `answer`
  /// becomes what to send back; it is left empty where there is nothing to say.
  const SharedKey* admit(const Peer& from, const Hello& hello, std::span<const std::byte> datagram, Time now,
                         std::vector<std::byte>& answer);
  void refuse_version(const ForeignHello& hello, std::vector<std::byte>& answer);

  /// A proved hello may have its handshake now; one less may later.
  [[nodiscard]] bool may_shake_hands(Time now);

  [[nodiscard]] const GateCounters& counters() const { return counters_; }

 private:
  [[nodiscard]] Cookie cookie_for(const Peer& from, const PublicKey& client, std::int64_t period) const;

  std::map<KeyId, SharedKey> ring_;
  std::array<std::uint8_t, 16>
      cookie_key_{};  ///< of this process; cookies of an earlier one mean a retry more
  double handshakes_per_second_, handshakes_left_;
  Time refilled_{};
  GateCounters counters_;
};

/// How long a cookie holds at most. Sessions must be remembered longer (SessionLimits), so that a repeated
/// hello finds the session that it has made.
inline constexpr Duration kCookiePeriod = std::chrono::seconds(2);
inline constexpr Duration kCookieLife = 2 * kCookiePeriod;

}  // namespace farshade
