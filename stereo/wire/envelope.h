/// Envelopes: what can be read of a datagram before it is opened. Magic, version and type; then the handshake
/// (handshake.h) or a sealed message (seal.h). PROTOCOL.md has the bytes and what each step defends against.
/// Nothing here is secret, and nothing is believed before it has opened.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "stereo/wire/key_file.h"
#include "stereo/wire/messages.h"

namespace farshade {

using PublicKey = std::array<std::uint8_t, 32>;  ///< X25519, of one handshake
using Echo = std::array<std::uint8_t, 16>;  ///< the first bytes of a hello's public key: which hello is meant
using Cookie = std::array<std::uint8_t, 16>;  ///< opaque to the client; zeros: has none yet

/// Chosen at random by the server: names a session wherever its client's datagrams come from.
struct SessionId {
  std::uint64_t value = 0;
  friend auto operator<=>(const SessionId&, const SessionId&) = default;
};

// ---- client -> server

/// Padded to kMaxDatagram_bytes, so that no answer is longer.
struct Hello {
  PublicKey client{};
  KeyId key{};
  ContentHash scene_hash{};
  Cookie cookie{};
  std::array<std::uint8_t, 32> proof{};  ///< keyed hash of all bytes before it
  friend bool operator==(const Hello&, const Hello&) = default;
};

/// A hello of another version; its layout beyond these is unknown.
struct ForeignHello {
  std::uint16_t version = 0;
  Echo echo{};
};

// ---- server -> client

/// Say it again, with this cookie: shows that the address is the client's own.
struct Retry {
  Echo echo{};
  Cookie cookie{};
  friend bool operator==(const Retry&, const Retry&) = default;
};

/// No, to somebody who has not proved a key. Its layout is the same in every version. Anyone could have sent
/// it: it explains, and ends nothing.
struct OpenRefusal {
  std::uint16_t version = kProtocolVersion;               ///< the server's
  RefusalReason reason = RefusalReason::VersionMismatch;  ///< VersionMismatch or UnknownKey
  Echo echo{};
  friend bool operator==(const OpenRefusal&, const OpenRefusal&) = default;
};

/// The server's half of the handshake, and its first sealed message: Welcome or Refusal.
struct Accept {
  Echo echo{};
  SessionId session{};
  PublicKey server{};
  std::span<const std::byte> sealed{};  ///< message and tag; a view into the datagram
};

/// A sealed datagram came for a session that the server does not have: it was restarted, or has forgotten it.
/// Anyone could have sent it: it lets a client say hello, and ends nothing.
struct NoSession {
  SessionId session{};
  friend bool operator==(const NoSession&, const NoSession&) = default;
};

// ---- both ways

struct Sealed {
  SessionId session{};
  std::uint64_t counter = 0;
  std::span<const std::byte> sealed{};  ///< message and tag; a view into the datagram
};

/// Bytes of a Sealed before `sealed`; they are authenticated with it.
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

/// Replaces `datagram` by the envelope's bytes. Of a Hello all but its proof must be set: what is proved is
/// its first kHelloProved_bytes bytes.
void encode(const Hello& hello, std::vector<std::byte>& datagram);
void encode(const Retry& retry, std::vector<std::byte>& datagram);
void encode(const OpenRefusal& refusal, std::vector<std::byte>& datagram);
void encode(const Accept& accept, std::vector<std::byte>& datagram);
void encode(const NoSession& no_session, std::vector<std::byte>& datagram);
void encode(const Sealed& sealed, std::vector<std::byte>& datagram);

[[nodiscard]] Decoded<ClientEnvelope> open_client_envelope(std::span<const std::byte> datagram);
[[nodiscard]] Decoded<ServerEnvelope> open_server_envelope(std::span<const std::byte> datagram);

}  // namespace farshade
