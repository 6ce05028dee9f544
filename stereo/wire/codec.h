/// Codec: one way to write and read any of several messages. A message brings three things by overload or
/// specialisation: `fields(io, message)`, one list for both directions; `verdict(message)`, its ranges; and
/// its number `kTypeOf<Message>`. For the .cpp files that define messages; nobody else includes it.
#pragma once

#include <concepts>
#include <optional>
#include <span>
#include <type_traits>
#include <variant>

#include "stereo/wire/bytes.h"
#include "stereo/wire/refusal.h"

namespace farshade::codec {

/// A message to be read, or one to be written.
template <class T, class Message>
concept Either = std::same_as<std::remove_const_t<T>, Message>;

/// Why a message may not be sent and is refused; nothing if it is fine.
using Verdict = std::optional<WireRefusal>;
inline constexpr Verdict kFine = std::nullopt;

template <class Message>
inline constexpr std::uint8_t kTypeOf = 0;

inline constexpr std::uint32_t kMagic = 0x48534446;  // "FDSH" in byte order

/// What every datagram begins with, in every version.
struct Header {
  std::uint32_t magic = kMagic;
  std::uint16_t version = 0;
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

/// Reads the one of `Messages` whose number is `type`.
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

}  // namespace farshade::codec
