/// Envelopes: the part of a datagram that is not encrypted. It has magic, version and type, and then a step
/// of the handshake (handshake.h) or a sealed message (seal.h). PROTOCOL.md has the bytes, and what each step
/// defends against. An envelope has no secrets, and is not trusted before its sealed part has opened.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "stereo/messages/layout_recorder.h"
#include "stereo/messages/messages.h"
#include "stereo/sealing/key_file.h"

namespace farshade {

// `version` is that of the header, which every envelope has; a server answers in that of the client's Hello.

using PublicKey = std::array<std::uint8_t, 32>;  ///< X25519, for one handshake
/// The first bytes of a Hello's public key: an answer repeats them to tell which Hello it answers.
using HelloEcho = std::array<std::uint8_t, 16>;
using Cookie = std::array<std::uint8_t, 16>;  ///< opaque to the client; zeros: the client has none yet

/// A random number from the server. It identifies a session, whatever address its client's datagrams come
/// from.
struct SessionId {
  std::uint64_t value = 0;
  friend auto operator<=>(const SessionId&, const SessionId&) = default;
};

// ---- client -> server

/// The first step of the handshake. Padded to kBaseDatagram_bytes, so that no answer is longer.
struct Hello {
  PublicKey client{};
  KeyId key{};
  ContentHash scene_hash{};
  Cookie cookie{};
  std::array<std::uint8_t, 32> proof{};  ///< keyed hash of all bytes before it
  ProtocolVersion version = kProtocolVersion;
  friend bool operator==(const Hello&, const Hello&) = default;
};

/// A Hello of a version that the server does not speak. Only these fields are the same in every version.
struct ForeignHello {
  ProtocolVersion version = 0;
  HelloEcho echo{};
};

// ---- server -> client

/// Asks for the same Hello with this cookie, which proves the client's address.
struct Retry {
  HelloEcho echo{};
  Cookie cookie{};
  ProtocolVersion version = kProtocolVersion;
  friend bool operator==(const Retry&, const Retry&) = default;
};

/// A refusal for a client that has not proved a key. Its layout is the same in every version. Anybody could
/// have sent it, so it gives the user a reason but does not end a session or a handshake.
struct OpenRefusal {
  ProtocolVersion version = kProtocolVersion;             ///< the server's
  RefusalReason reason = RefusalReason::VersionMismatch;  ///< VersionMismatch or UnknownKey
  HelloEcho echo{};
  friend bool operator==(const OpenRefusal&, const OpenRefusal&) = default;
};

/// The server's half of the handshake, and its first sealed message: Welcome or Refusal.
struct Accept {
  HelloEcho echo{};
  SessionId session{};
  PublicKey server{};
  std::span<const std::byte> sealed{};  ///< message and tag; a view into the datagram
  ProtocolVersion version = kProtocolVersion;
};

/// The server does not have the session of a sealed datagram: it was restarted, or the session timed out.
/// Anybody could have sent it, so it makes a client send a Hello but does not end the session.
struct NoSession {
  SessionId session{};
  ProtocolVersion version = kProtocolVersion;
  friend bool operator==(const NoSession&, const NoSession&) = default;
};

// ---- both ways

struct Sealed {
  SessionId session{};
  std::uint64_t counter = 0;            ///< on the wire the low 48 bits of eight bytes
  std::span<const std::byte> sealed{};  ///< message and tag; a view into the datagram
  std::uint16_t epoch = 0;              ///< number of the key (seal.h): the high 16 bits
  ProtocolVersion version = kProtocolVersion;
};

/// Bytes of a Sealed before `sealed`. The tag authenticates them, too.
inline constexpr std::size_t kSealedHeader_bytes = 23;
/// Bytes of an Accept before `sealed`.
inline constexpr std::size_t kAcceptHeader_bytes = 63;
/// Bytes of a Hello before its cookie: the same in every hello of one handshake.
inline constexpr std::size_t kHelloLasting_bytes = 79;
/// Bytes of a Hello before its proof.
inline constexpr std::size_t kHelloProved_bytes = 95;
inline constexpr std::size_t kTag_bytes = 16;
static_assert(kSealing_bytes == kSealedHeader_bytes + kTag_bytes);

using ClientEnvelope = std::variant<Hello, ForeignHello, Sealed>;
using ServerEnvelope = std::variant<Retry, OpenRefusal, Accept, NoSession, Sealed>;

using Envelope = std::variant<Hello, Retry, OpenRefusal, Accept, NoSession, Sealed>;

/// Replaces `datagram` by the envelope's bytes. The proof of a Hello covers its first kHelloProved_bytes
/// bytes, so the caller encodes it once without the proof and once with it.
void encode(const Envelope& envelope, std::vector<std::byte>& datagram);

[[nodiscard]] Decoded<ClientEnvelope> open_client_envelope(std::span<const std::byte> datagram);
[[nodiscard]] Decoded<ServerEnvelope> open_server_envelope(std::span<const std::byte> datagram);

/// Records the fields of all envelopes.
void record_envelopes(LayoutRecorder& io);

}  // namespace farshade
