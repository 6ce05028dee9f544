#include "rt_server/sessions/client_path.h"

#include <sodium.h>

namespace farshade {

std::uint64_t random_token() {
  std::uint64_t token = 0;
  while (token == 0) randombytes_buf(&token, sizeof token);
  return token;
}

void ClientPath::limit(const RateLimits& limits) {
  limits_ = limits;
  rate.limit(limits);
}

std::optional<std::uint64_t> ClientPath::update_address(const Peer& from, bool newest,
                                                        std::uint64_t probe_echo) {
  if (from == client_) {
    if (newest) candidate_.reset();
    return std::nullopt;
  }
  if (from == candidate_ && probe_echo == probe_token_) {
    client_ = from;
    candidate_.reset();
    const bool got_false_report = rate.got_false_report();
    rate = RateControl(limits_);  // nothing is known about the new path, but about the client
    if (got_false_report) rate.distrust();
    mtu = PathMtu();
    return std::nullopt;
  }
  if (!newest) return std::nullopt;
  if (from != candidate_) {
    candidate_ = from;
    probe_token_ = random_token();
  }
  return probe_token_;
}

}  // namespace farshade
