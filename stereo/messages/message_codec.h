/// Codec: reads and writes any of several messages. For each message there are three overloads or
/// specialisations: `fields(io, message)`, its fields for both directions; `verdict(message)`, its range
/// checks; and `kTypeOf<Message>`, its type number. Only the .cpp files that define messages include it.
#pragma once

#include <concepts>
#include <optional>
#include <type_traits>
#include <variant>

#include "stereo/messages/bytes.h"
#include "stereo/messages/layout_recorder.h"
#include "stereo/messages/refusal.h"

namespace farshade::codec {

/// A message that is read (mutable) or written (const).
template <class T, class Message>
concept Either = std::same_as<std::remove_const_t<T>, Message>;

/// The reason to refuse a message; empty if it is valid.
using Verdict = std::optional<WireRefusal>;
inline constexpr Verdict kFine = std::nullopt;

template <class Message>
inline constexpr std::uint8_t kTypeOf = 0;

inline constexpr std::uint32_t kMagic = 0x48534446;  // "FDSH" in byte order

/// The beginning of every datagram, in every version.
struct Header {
  std::uint32_t magic = kMagic;
  ProtocolVersion version = 0;
  std::uint8_t type = 0;
};

bool fields(auto& io, Either<Header> auto& header) {
  return io.u32(header.magic) && io.u16(header.version) && io.u8(header.type);
}

template <class Message>
Decoded<Message> read(ByteReader io) {
  Message message{};
  if (!fields(io, message)) return refuse(WireRefusal::Truncated);
  if (const Verdict why = verdict(message)) return refuse(*why);
  if (io.remaining() > 0) return refuse(WireRefusal::TrailingBytes);
  return message;
}

/// Replaces `bytes` by the type and the fields of the message that `any` holds, which must be within its
/// ranges and have at most `most_bytes`.
template <class... Messages>
void encode_any(const std::variant<Messages...>& any, std::size_t most_bytes, std::vector<std::byte>& bytes,
                ProtocolVersion version = kProtocolVersion) {
  bytes.clear();
  ByteWriter io(bytes, version);
  std::visit(
      [&io]<class Message>(const Message& message) {
        check(!verdict(message), "a message is within its ranges before it is sent");
        io.u8(kTypeOf<Message>);
        fields(io, message);
      },
      any);
  check(bytes.size() <= most_bytes, "a message fits into a sealed datagram");
}

/// Reads the one of `Messages` whose type number is `type`.
template <class... Messages>
Decoded<std::variant<Messages...>> read_any(std::type_identity<std::variant<Messages...>>, std::uint8_t type,
                                            ByteReader io) {
  Decoded<std::variant<Messages...>> any = refuse(WireRefusal::Type);
  const auto take = [&]<class Message>(std::type_identity<Message>) {
    Decoded<Message> message = read<Message>(io);
    if (message)
      any = std::move(*message);
    else
      any = refuse(message.error());
  };
  static_cast<void>(((type == kTypeOf<Messages> && (take(std::type_identity<Messages>{}), true)) || ...));
  return any;
}

/// Reads what encode_any has written: `Any` is a std::variant of messages.
template <class Any>
Decoded<Any> decode_any(std::span<const std::byte> bytes, std::size_t most_bytes,
                        ProtocolVersion version = kProtocolVersion) {
  if (bytes.size() > most_bytes) return refuse(WireRefusal::TooLong);
  ByteReader io(bytes, version);
  std::uint8_t type = 0;
  if (!io.u8(type)) return refuse(WireRefusal::Truncated);
  return read_any(std::type_identity<Any>{}, type, io);
}

/// Records the fields of each of `Messages`.
template <class... Messages>
void record_any(std::type_identity<std::variant<Messages...>>, LayoutRecorder& io) {
  const auto record = [&]<class Message>(Message message) {
    io.type(kTypeOf<Message>);
    fields(io, message);
  };
  (record(Messages{}), ...);
}

}  // namespace farshade::codec
