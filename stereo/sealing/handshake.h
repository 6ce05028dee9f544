/// Handshake: a client that shares a key with the server gets a session in two round trips: Hello, Retry with
/// a cookie, Hello with the cookie, Accept. X25519 with two ephemeral keys gives forward secrecy. The session
/// keys also depend on the shared key, which authenticates both sides: the server has proved it when the
/// Accept opens, the client when its first sealed datagram opens. This file has no sockets, no clocks and no
/// state of the server.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "stereo/sealing/seal.h"

namespace farshade {

/// A key that everybody knows. Sessions with it are not sealed. It is for tests on one machine (--insecure).
[[nodiscard]] const SharedKey& insecure_key();

/// The keys of a session, equal on both sides.
struct SessionKeys {
  SessionId session;
  Secret to_server, to_client;
  Sealing sealing = Sealing::On;
  ProtocolVersion version = kProtocolVersion;
};

/// The client's side of one handshake, with its own ephemeral key.
class ClientHandshake {
 public:
  ClientHandshake(const SharedKey& key, const ContentHash& scene_hash,
                  ProtocolVersion version = kProtocolVersion);

  /// Replaces `datagram` by the Hello to send now.
  void write_hello(std::vector<std::byte>& datagram) const;

  /// Keeps the Retry's cookie; the caller sends another Hello at once. False: it does not answer this Hello.
  [[nodiscard]] bool take(const Retry& retry);

  struct Completed {
    SessionKeys keys;
    ServerMessage answer;  ///< Welcome or Refusal
  };
  /// `accept` was read from `datagram`. Returns nothing if it does not answer this Hello, or if its sender
  /// does not have the key.
  [[nodiscard]] std::optional<Completed> take(const Accept& accept,
                                              std::span<const std::byte> datagram) const;

  [[nodiscard]] HelloEcho echo() const;

 private:
  SharedKey key_;
  ContentHash scene_hash_;
  ProtocolVersion version_;
  PublicKey public_{};
  Secret secret_;
  Cookie cookie_{};
};

/// Whether the sender of `hello`, read from `datagram`, has `key`.
[[nodiscard]] bool is_proved(const Hello& hello, std::span<const std::byte> datagram, const SharedKey& key);

[[nodiscard]] HelloEcho echo_of(const PublicKey& client);

/// The server's side: new session keys, and the datagram that answers `hello` with `answer` (Welcome or
/// Refusal). Call it for a proved Hello only. Two calls for the same Hello give two sessions. Returns nothing
/// if the client's public key gives no secret.
struct Accepted {
  SessionKeys keys;
  std::vector<std::byte> datagram;
};
[[nodiscard]] std::optional<Accepted> accept(const Hello& hello, std::span<const std::byte> hello_datagram,
                                             const SharedKey& key, const ServerMessage& answer);

}  // namespace farshade
