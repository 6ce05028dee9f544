/// Handshake: how a client that shares a key with the server gets a session, in two round trips: hello, retry
/// with a cookie, hello with the cookie, accept. X25519 of two keys made for this once gives forward secrecy,
/// the shared key mixed in says who is there; both sides have proved it when the accept, and the first sealed
/// datagram after it, have opened. Values and functions: no sockets, no clocks, no state of the server.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "stereo/wire/seal.h"

namespace farshade {

/// The key that everyone knows. Sessions made with it are not sealed: for one machine, where a server was
/// told so.
[[nodiscard]] const SharedKey& insecure_key();

/// What both sides hold once they have met.
struct SessionKeys {
  SessionId session;
  Secret to_server, to_client;
  Sealing sealing = Sealing::On;
};

/// One client's attempt, with keys of its own.
class ClientHandshake {
 public:
  ClientHandshake(const SharedKey& key, const ContentHash& scene_hash);

  /// Replaces `datagram` by the hello to send now.
  void write_hello(std::vector<std::byte>& datagram) const;

  /// Another hello should be sent at once, with the cookie now in hand. False: it answers no hello of ours.
  [[nodiscard]] bool take(const Retry& retry);

  struct Met {
    SessionKeys keys;
    ServerMessage answer;  ///< Welcome or Refusal
  };
  /// `datagram` is the one that `accept` was read from. Nothing: it answers no hello of ours, or its sender
  /// does not have the key.
  [[nodiscard]] std::optional<Met> take(const Accept& accept, std::span<const std::byte> datagram) const;

  [[nodiscard]] Echo echo() const;

 private:
  SharedKey key_;
  ContentHash scene_hash_;
  PublicKey public_{};
  Secret secret_;
  Cookie cookie_{};
};

/// `hello` was made by who has `key`; `datagram` is the one that it was read from.
[[nodiscard]] bool is_proved(const Hello& hello, std::span<const std::byte> datagram, const SharedKey& key);

[[nodiscard]] Echo echo_of(const PublicKey& client);

/// The server's side: fresh keys, and the datagram that answers `hello` with `answer`. Call it for a proved
/// hello only; two calls for one hello give two sessions.
struct Accepted {
  SessionKeys keys;
  std::vector<std::byte> datagram;
};
[[nodiscard]] std::optional<Accepted> accept(const Hello& hello, std::span<const std::byte> hello_datagram,
                                             const SharedKey& key, const ServerMessage& answer);

}  // namespace farshade
