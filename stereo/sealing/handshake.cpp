#include "stereo/sealing/handshake.h"

#include <sodium.h>

#include <algorithm>
#include <string_view>

#include "stereo/base/check.h"

namespace farshade {
namespace {

static_assert(sizeof(PublicKey) == crypto_kx_PUBLICKEYBYTES && Secret::size() == crypto_kx_SECRETKEYBYTES);
static_assert(Secret::size() == crypto_kx_SESSIONKEYBYTES);

/// BLAKE2b-256 of a sequence of parts, with or without a key.
class Hash {
 public:
  explicit Hash(std::span<const std::uint8_t> key = {}) {
    crypto_generichash_init(&state_, key.data(), key.size(), 32);
  }
  Hash(const Hash&) = delete;
  Hash& operator=(const Hash&) = delete;
  ~Hash() { sodium_memzero(&state_, sizeof state_); }
  Hash& add(std::span<const std::byte> bytes) {
    crypto_generichash_update(&state_, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    return *this;
  }
  Hash& add(std::string_view label) { return add(std::as_bytes(std::span(label))); }
  Hash& add(const Secret& secret) {
    crypto_generichash_update(&state_, secret.data(), Secret::size());
    return *this;
  }
  std::array<std::uint8_t, 32> finish() {
    std::array<std::uint8_t, 32> digest;
    crypto_generichash_final(&state_, digest.data(), digest.size());
    return digest;
  }

 private:
  crypto_generichash_state state_;
};

void ready() {
  check(sodium_init() >= 0, "libsodium can be initialised");
}

std::array<std::uint8_t, 32> proof_of(std::span<const std::byte> hello_datagram, const SharedKey& key) {
  return Hash(key.secret).add("farshade-2 hello").add(hello_datagram.first(kHelloProved_bytes)).finish();
}

/// The key schedule of one session: two X25519 secrets (crypto_kx), the shared key, and the transcript of the
/// unencrypted handshake.
struct Schedule {
  Secret up, down;  ///< from crypto_kx: from the client, and to the client
  const SharedKey& key;
  std::array<std::uint8_t, 32> transcript;

  [[nodiscard]] Secret derive(std::string_view label) const {
    return Secret(
        Hash(key.secret).add(label).add(up).add(down).add(std::as_bytes(std::span(transcript))).finish());
  }
  [[nodiscard]] SessionKeys session(SessionId id, ProtocolVersion version) const {
    return {.session = id,
            .to_server = derive("farshade-2 to server"),
            .to_client = derive("farshade-2 to client"),
            .sealing = key == insecure_key() ? Sealing::Off : Sealing::On,
            .version = version};
  }
  [[nodiscard]] Secret accept_key() const { return derive("farshade-2 accept"); }
};

/// Excludes the cookie and the proof, which covers the cookie: an Accept that was on its way when the client
/// got a newer cookie still opens.
std::array<std::uint8_t, 32> transcript_of(std::span<const std::byte> hello_datagram,
                                           std::span<const std::byte> accept_datagram) {
  return Hash()
      .add(hello_datagram.first(kHelloLasting_bytes))
      .add(accept_datagram.first(kAcceptHeader_bytes))
      .finish();
}

SessionId random_session() {
  SessionId id;
  randombytes_buf(&id.value, sizeof id.value);
  return id;
}

}  // namespace

const SharedKey& insecure_key() {
  static const SharedKey key{.name = "insecure"};
  return key;
}

HelloEcho echo_of(const PublicKey& client) {
  HelloEcho echo;
  std::copy_n(client.begin(), echo.size(), echo.begin());
  return echo;
}

ClientHandshake::ClientHandshake(const SharedKey& key, const ContentHash& scene_hash, ProtocolVersion version)
    : key_(key), scene_hash_(scene_hash), version_(version) {
  ready();
  crypto_kx_keypair(public_.data(), secret_.data());
}

HelloEcho ClientHandshake::echo() const {
  return echo_of(public_);
}

void ClientHandshake::write_hello(std::vector<std::byte>& datagram) const {
  Hello hello{.client = public_, .key = id_of(key_), .scene_hash = scene_hash_, .cookie = cookie_};
  hello.version = version_;
  encode(hello, datagram);
  hello.proof = proof_of(datagram, key_);
  encode(hello, datagram);
}

bool ClientHandshake::take(const Retry& retry) {
  if (retry.echo != echo()) return false;
  cookie_ = retry.cookie;
  return true;
}

std::optional<ClientHandshake::Completed> ClientHandshake::take(const Accept& accept,
                                                                std::span<const std::byte> datagram) const {
  if (accept.echo != echo()) return std::nullopt;
  std::vector<std::byte> hello;
  write_hello(hello);
  Schedule schedule{.up = {}, .down = {}, .key = key_, .transcript = transcript_of(hello, datagram)};
  if (crypto_kx_client_session_keys(schedule.down.data(), schedule.up.data(), public_.data(), secret_.data(),
                                    accept.server.data()) != 0)
    return std::nullopt;
  const SessionKeys keys = schedule.session(accept.session, version_);
  std::vector<std::byte> message;
  if (!open_alone(schedule.accept_key(), keys.sealing, accept.sealed, message)) return std::nullopt;
  const Decoded<ServerMessage> answer = decode_server(message, version_);
  if (!answer || !(std::holds_alternative<Welcome>(*answer) || std::holds_alternative<Refusal>(*answer)))
    return std::nullopt;
  return Completed{keys, *answer};
}

bool is_proved(const Hello& hello, std::span<const std::byte> datagram, const SharedKey& key) {
  const auto proof = proof_of(datagram, key);
  return sodium_memcmp(proof.data(), hello.proof.data(), proof.size()) == 0;
}

std::optional<Accepted> accept(const Hello& hello, std::span<const std::byte> hello_datagram,
                               const SharedKey& key, const ServerMessage& answer) {
  ready();
  Accept accept{.echo = echo_of(hello.client), .session = random_session(), .version = hello.version};
  Secret secret;
  crypto_kx_keypair(accept.server.data(), secret.data());
  Accepted accepted;
  encode(accept, accepted.datagram);
  Schedule schedule{
      .up = {}, .down = {}, .key = key, .transcript = transcript_of(hello_datagram, accepted.datagram)};
  if (crypto_kx_server_session_keys(schedule.up.data(), schedule.down.data(), accept.server.data(),
                                    secret.data(), hello.client.data()) != 0)
    return std::nullopt;
  accepted.keys = schedule.session(accept.session, hello.version);
  std::vector<std::byte> message;
  encode(answer, message, hello.version);
  const std::vector<std::byte> sealed = seal_alone(schedule.accept_key(), accepted.keys.sealing, message);
  accepted.datagram.insert(accepted.datagram.end(), sealed.begin(), sealed.end());
  return accepted;
}

}  // namespace farshade
