/// Datagrams that only a holder of a key can make, and that no genuine program makes.
#pragma once

#include <sodium.h>

#include <string_view>
#include <vector>

#include "stereo/sealing/handshake.h"

namespace farshade::link_test {

inline const std::uint8_t* octets(std::span<const std::byte> bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

/// `message` sealed with a counter of the caller's choice. A Sealer only counts up by one.
inline std::vector<std::byte> seal_at(std::uint64_t counter, SessionId session, const Secret& key,
                                      std::span<const std::byte> message) {
  std::vector<std::byte> datagram;
  encode(Sealed{session, counter, {}}, datagram);
  std::array<std::uint8_t, crypto_aead_chacha20poly1305_ietf_NPUBBYTES> nonce{};
  for (std::size_t i = 0; i < 8; ++i) nonce[4 + i] = static_cast<std::uint8_t>(counter >> (8 * i));
  datagram.resize(kSealedHeader_bytes + message.size() + kTag_bytes);
  crypto_aead_chacha20poly1305_ietf_encrypt(
      reinterpret_cast<std::uint8_t*>(datagram.data() + kSealedHeader_bytes), nullptr, octets(message),
      message.size(), octets(datagram), kSealedHeader_bytes, nullptr, nonce.data(), key.data());
  return datagram;
}

/// A Hello with the public key of another client's hello, as the holder of `key` can make it.
inline std::vector<std::byte> hello_with(const PublicKey& client, const SharedKey& key,
                                         const ContentHash& scene, const Cookie& cookie) {
  Hello hello{.client = client, .key = id_of(key), .scene_hash = scene, .cookie = cookie};
  std::vector<std::byte> datagram;
  encode(hello, datagram);
  crypto_generichash_state state;
  crypto_generichash_init(&state, key.secret.data(), key.secret.size(), hello.proof.size());
  const auto label = std::as_bytes(std::span(std::string_view("farshade-2 hello")));
  crypto_generichash_update(&state, octets(label), label.size());
  crypto_generichash_update(&state, octets(datagram), kHelloProved_bytes);
  crypto_generichash_final(&state, hello.proof.data(), hello.proof.size());
  encode(hello, datagram);
  return datagram;
}

}  // namespace farshade::link_test
