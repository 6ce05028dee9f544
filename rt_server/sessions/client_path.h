/// ClientPath: the address that a client has proved, and what is known about the path there: the rate and the
/// largest datagram that it carries. Frames follow the client to another address only after a datagram from
/// there has returned the token that was sent there. An attacker who intercepts a datagram and sends it from
/// elsewhere cannot read the token.
#pragma once

#include <cstdint>
#include <optional>

#include "stereo/net/datagram.h"
#include "stereo/net/path_mtu.h"
#include "stereo/net/rate_control.h"

namespace farshade {

/// Not 0.
[[nodiscard]] std::uint64_t random_token();

class ClientPath {
 public:
  ClientPath(const Peer& client, const RateLimits& limits) : rate(limits), client_(client), limits_(limits) {}

  /// Sets the limits of the rate from now on.
  void limit(const RateLimits& limits);
  /// The rate, in bytes per second, is not the path's but its limit.
  [[nodiscard]] bool is_limited() const { return rate.bytes_per_second() >= limits_.most; }

  /// The proved address: frames go there.
  [[nodiscard]] const Peer& client() const { return client_; }

  /// A request has come from `from`, in the `newest` datagram or in an older one, with the token of the last
  /// probe that reached the client. Returns the token that a probe to `from` must carry, if one is to be
  /// sent. When the client has moved, nothing is known about the new path.
  [[nodiscard]] std::optional<std::uint64_t> update_address(const Peer& from, bool newest,
                                                            std::uint64_t probe_echo);

  RateControl rate;
  PathMtu mtu;

 private:
  Peer client_;
  std::optional<Peer> candidate_{};  ///< another address, from which the newest datagrams came
  std::uint64_t probe_token_ = 0;    ///< sent to the candidate, which must send it back
  RateLimits limits_;
};

}  // namespace farshade
