/// Gate: what a client must prove before the server stores anything for it. A hello is first answered with a
/// cookie. The hello that brings the cookie back proves the client's address, and its proof shows that the
/// client has a key of the ring. No answer is longer than the hello. A value without sockets, threads or
/// clocks.
#pragma once

#include <map>
#include <vector>

#include "rt_server/admission/key_ledger.h"
#include "stereo/messages/timing.h"
#include "stereo/net/datagram.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

struct GateCounters {
  std::uint64_t retries = 0;           ///< hellos without a valid cookie
  std::uint64_t version_mismatch = 0;  ///< hellos of another protocol version
  std::uint64_t unknown_key = 0;       ///< hellos whose key is not in the ring, or whose proof is wrong
  std::uint64_t expired_key = 0;       ///< hellos that prove a key whose time is over
  std::uint64_t too_many = 0;          ///< valid hellos over the limit of handshakes per second
  friend bool operator==(const GateCounters&, const GateCounters&) = default;
};

class Gate {
 public:
  /// The keys of `ring` have different secrets. `handshakes_per_second` is the rate of a token bucket that
  /// holds the tokens of one second.
  Gate(const std::vector<SharedKey>& ring, double handshakes_per_second);

  /// From now on admits only clients with these keys, if they are valid on `today`.
  void set_ring(const std::vector<SharedKey>& ring, std::chrono::sys_days today);

  /// Returns the key that `hello`, read from `datagram`, proves; the gate owns it. Otherwise returns null,
  /// and `answer` becomes the datagram to send back.
  const SharedKey* admit(const Peer& from, const Hello& hello, std::span<const std::byte> datagram, Time now,
                         std::vector<std::byte>& answer);
  /// The keys that are valid, and those whose time is over.
  [[nodiscard]] const KeyRing& ring() const { return ring_; }
  [[nodiscard]] const KeyRing& expired() const { return expired_; }

  /// `answer` becomes a refusal that names our protocol version.
  void refuse_version(const ForeignHello& hello, std::vector<std::byte>& answer);

  /// Whether a client with a valid hello may have its handshake now. If so, takes one of those of `key`, its
  /// key, and one of those that all keys share if it has none of its own left.
  [[nodiscard]] bool may_shake_hands(KeyHandshakes& key, Time now);

  [[nodiscard]] const GateCounters& counters() const { return counters_; }

 private:
  [[nodiscard]] Cookie cookie_for(const Peer& from, const PublicKey& client, std::int64_t period) const;

  KeyRing ring_, expired_;
  std::array<std::uint8_t, 16> cookie_key_{};  ///< new in each process: cookies of an earlier one are invalid
  double handshakes_per_second_;
  TokenBucket shared_handshakes_;
  GateCounters counters_;
};

}  // namespace farshade
