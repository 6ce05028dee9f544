#include "rt_server/admission/gate.h"

#include <sodium.h>

#include "stereo/base/check.h"
#include "stereo/messages/bytes.h"

namespace farshade {

Gate::Gate(const std::vector<SharedKey>& ring, double handshakes_per_second)
    : handshakes_per_second_(handshakes_per_second), shared_handshakes_(handshakes_per_second) {
  check(sodium_init() >= 0, "libsodium can be initialised");
  set_ring(ring, {});
  randombytes_buf(cookie_key_.data(), cookie_key_.size());
}

void Gate::set_ring(const std::vector<SharedKey>& ring, std::chrono::sys_days today) {
  const bool was_alone = ring_.size() <= 1;
  ring_.clear();
  expired_.clear();
  for (const SharedKey& key : ring) (is_valid_on(key, today) ? ring_ : expired_).emplace(id_of(key), key);
  const bool is_alone = ring_.size() <= 1;
  if (is_alone != was_alone)
    shared_handshakes_ = TokenBucket(is_alone ? handshakes_per_second_ : 0.5 * handshakes_per_second_);
}

Cookie Gate::cookie_for(const Peer& from, const PublicKey& client, std::int64_t period) const {
  std::vector<std::byte> bytes;
  bytes.reserve(64);
  ByteWriter io(bytes);
  io.array(from.address);
  io.u32(from.scope);
  io.u16(from.port);
  io.array(client);
  io.u64(static_cast<std::uint64_t>(period));
  Cookie cookie;
  static_assert(sizeof cookie == crypto_shorthash_siphashx24_BYTES);
  static_assert(sizeof cookie_key_ == crypto_shorthash_siphashx24_KEYBYTES);
  crypto_shorthash_siphashx24(cookie.data(), reinterpret_cast<const std::uint8_t*>(bytes.data()),
                              bytes.size(), cookie_key_.data());
  return cookie;
}

const SharedKey* Gate::admit(const Peer& from, const Hello& hello, std::span<const std::byte> datagram,
                             Time now, std::vector<std::byte>& answer) {
  const std::int64_t period = now.time_since_epoch() / kCookiePeriod;
  const Cookie fresh = cookie_for(from, hello.client, period);
  const auto matches = [&](const Cookie& cookie) {
    return sodium_memcmp(cookie.data(), hello.cookie.data(), 16) == 0;
  };
  if (!matches(fresh) && !matches(cookie_for(from, hello.client, period - 1))) {
    ++counters_.retries;
    encode(Retry{echo_of(hello.client), fresh, hello.version}, answer);
    return nullptr;
  }
  const auto found = ring_.find(hello.key);
  if (found == ring_.end() || !is_proved(hello, datagram, found->second)) {
    const auto over = expired_.find(hello.key);
    const bool expired = over != expired_.end() && is_proved(hello, datagram, over->second);
    ++(expired ? counters_.expired_key : counters_.unknown_key);
    // The client is told no more than a stranger: its refusal is not encrypted.
    encode(OpenRefusal{.reason = RefusalReason::UnknownKey, .echo = echo_of(hello.client)}, answer);
    return nullptr;
  }
  return &found->second;
}

void Gate::refuse_version(const ForeignHello& hello, std::vector<std::byte>& answer) {
  ++counters_.version_mismatch;
  encode(OpenRefusal{.reason = RefusalReason::VersionMismatch, .echo = hello.echo}, answer);
}

bool Gate::may_shake_hands(KeyHandshakes& key, Time now) {
  const bool has_own = key.own.has_token(now);
  if (!key.all.has_token(now) || !(has_own || shared_handshakes_.has_token(now))) {
    ++counters_.too_many;
    return false;
  }
  key.all.take();
  (has_own ? key.own : shared_handshakes_).take();
  return true;
}

}  // namespace farshade
