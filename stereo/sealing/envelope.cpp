#include "stereo/sealing/envelope.h"

#include <algorithm>

#include "stereo/messages/message_codec.h"

namespace farshade {

namespace codec {
template <>
inline constexpr std::uint8_t kTypeOf<Hello> = 1;
template <>
inline constexpr std::uint8_t kTypeOf<Retry> = 2;
template <>
inline constexpr std::uint8_t kTypeOf<OpenRefusal> = 3;
template <>
inline constexpr std::uint8_t kTypeOf<Accept> = 4;
template <>
inline constexpr std::uint8_t kTypeOf<NoSession> = 5;
template <>
inline constexpr std::uint8_t kTypeOf<Sealed> = 6;
}  // namespace codec

using codec::Either;
using codec::kFine;
using codec::Verdict;

bool fields(auto& io, Either<SessionId> auto& session) {
  return io.u64(session.value);
}

bool fields(auto& io, Either<Hello> auto& hello) {
  return io.array(hello.client) && io.array(hello.key) && io.array(hello.scene_hash) &&
         io.array(hello.cookie) && io.array(hello.proof);
}

bool fields(auto& io, Either<Retry> auto& retry) {
  return io.array(retry.echo) && io.array(retry.cookie);
}

bool fields(auto& io, Either<OpenRefusal> auto& refusal) {
  return io.code(refusal.reason) && io.array(refusal.echo);
}

bool fields(auto& io, Either<Accept> auto& accept) {
  return io.array(accept.echo) && fields(io, accept.session) && io.array(accept.server) &&
         io.rest(accept.sealed);
}

bool fields(auto& io, Either<NoSession> auto& no_session) {
  return fields(io, no_session.session);
}

constexpr unsigned kCounterBits = 48;

bool fields(ByteWriter& io, const Sealed& sealed) {
  return fields(io, sealed.session) && io.u64(std::uint64_t{sealed.epoch} << kCounterBits | sealed.counter) &&
         io.rest(sealed.sealed);
}
bool fields(Reader auto& io, Sealed& sealed) {
  std::uint64_t both = 0;
  if (!fields(io, sealed.session) || !io.u64(both)) return false;
  sealed.epoch = static_cast<std::uint16_t>(both >> kCounterBits);
  sealed.counter = both & ((std::uint64_t{1} << kCounterBits) - 1);
  return io.rest(sealed.sealed);
}

Verdict verdict(const Retry&) {
  return kFine;
}
Verdict verdict(const OpenRefusal& refusal) {
  const bool open =
      refusal.reason == RefusalReason::VersionMismatch || refusal.reason == RefusalReason::UnknownKey;
  return open ? kFine : WireRefusal::Code;
}
Verdict verdict(const Accept& accept) {
  return accept.sealed.size() >= kTag_bytes ? kFine : WireRefusal::Truncated;
}
Verdict verdict(const NoSession&) {
  return kFine;
}
Verdict verdict(const Sealed& sealed) {
  return sealed.sealed.size() >= kTag_bytes ? kFine : WireRefusal::Truncated;
}

namespace {

Decoded<codec::Header> read_header(ByteReader& io, std::size_t most_bytes) {
  codec::Header header;
  if (io.remaining() > most_bytes) return refuse(WireRefusal::TooLong);
  if (!fields(io, header)) return refuse(WireRefusal::Truncated);
  if (header.magic != codec::kMagic) return refuse(WireRefusal::Magic);
  return header;
}

/// What follows the header, to be read as `version` has it.
ByteReader body_of(ByteReader io, ProtocolVersion version) {
  std::span<const std::byte> body;
  io.rest(body);
  return ByteReader(body, version);
}

/// Cheapest checks first, so that a flood of Hellos is cheap.
Decoded<ClientEnvelope> read_hello(ByteReader io, ProtocolVersion version) {
  if (io.remaining() + 7 != kBaseDatagram_bytes) return refuse(WireRefusal::Padding);
  if (!is_spoken(version)) {
    ForeignHello foreign{.version = version};
    io.array(foreign.echo);
    return foreign;
  }
  Hello hello;
  fields(io, hello);
  hello.version = version;
  std::span<const std::byte> padding;
  io.rest(padding);
  if (std::ranges::any_of(padding, [](std::byte b) { return b != std::byte{0}; }))
    return refuse(WireRefusal::Padding);
  return hello;
}

}  // namespace

void encode(const Envelope& any, std::vector<std::byte>& datagram) {
  datagram.clear();
  std::visit(
      [&]<class Kind>(const Kind& envelope) {
        ByteWriter io(datagram, envelope.version);
        const codec::Header header{.version = envelope.version, .type = codec::kTypeOf<Kind>};
        fields(io, header);
        fields(io, envelope);
      },
      any);
  check(datagram.size() <= kMaxDatagram_bytes, "an envelope fits into a datagram");
  if (std::holds_alternative<Hello>(any)) datagram.resize(kBaseDatagram_bytes);
}

Decoded<ClientEnvelope> open_client_envelope(std::span<const std::byte> datagram) {
  ByteReader io(datagram);
  const Decoded<codec::Header> header = read_header(io, kBaseDatagram_bytes);
  if (!header) return refuse(header.error());
  if (header->type == codec::kTypeOf<Hello>) return read_hello(body_of(io, header->version), header->version);
  if (!is_spoken(header->version)) return refuse(WireRefusal::Version);
  if (header->type != codec::kTypeOf<Sealed>) return refuse(WireRefusal::Type);
  ByteReader body = body_of(io, header->version);
  Decoded<Sealed> sealed = codec::read<Sealed>(body);
  if (!sealed) return refuse(sealed.error());
  sealed->version = header->version;
  return *sealed;
}

Decoded<ServerEnvelope> open_server_envelope(std::span<const std::byte> datagram) {
  ByteReader io(datagram);
  const Decoded<codec::Header> header = read_header(io, kMaxDatagram_bytes);
  if (!header) return refuse(header.error());
  if (!is_spoken(header->version) && header->type != codec::kTypeOf<OpenRefusal>)
    return refuse(WireRefusal::Version);
  ByteReader body = body_of(io, header->version);
  Decoded<ServerEnvelope> envelope =
      codec::read_any(std::type_identity<ServerEnvelope>{}, header->type, body);
  if (envelope) std::visit([&](auto& any) { any.version = header->version; }, *envelope);
  return envelope;
}

void record_envelopes(LayoutRecorder& io) {
  codec::Header header;
  fields(io, header);
  codec::record_any(std::type_identity<Envelope>{}, io);
}

}  // namespace farshade
