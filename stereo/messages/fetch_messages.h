/// The messages of a scene fetch, sealed (stereo/net/sealed_stream.h). A decoder refuses every other byte
/// string.
#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "stereo/messages/messages.h"

namespace farshade {

// ---- client -> server

struct OfferRequest {};

/// Bytes [begin, end) of the content: all files of the offer, one after the other.
struct ContentRequest {
  std::uint64_t begin = 0, end = 0;
};

using FetchRequest = std::variant<OfferRequest, ContentRequest>;

// ---- server -> client

/// The next bytes of the offer (scene_offer.h).
struct OfferPart {
  enum class More : std::uint8_t { No, Yes };
  More more = More::No;
  std::span<const std::byte> bytes{};  ///< points into the received message
};

/// The next bytes of the requested range.
struct Content {
  std::uint64_t begin = 0;
  std::span<const std::byte> bytes{};  ///< at least one; points into the received message
};

/// The server sends nothing more.
enum class FetchRefusal : std::uint8_t {
  Busy = 1,        ///< it sends its scene to as many clients as it may
  Changed = 2,     ///< a file is not what it was when the server started
  Unreadable = 3,  ///< the files cannot be offered: too many, too large, or not readable
};

using FetchAnswer = std::variant<OfferPart, Content, FetchRefusal>;

inline constexpr std::size_t kContentHeader_bytes = 9;
inline constexpr std::size_t kMaxContent_bytes = kBaseMessage_bytes - kContentHeader_bytes;
inline constexpr std::size_t kMaxOfferPart_bytes = kBaseMessage_bytes - 2;

/// Replaces `bytes` by the message. A server passes the `version` of the stream.
void encode(const FetchRequest& message, std::vector<std::byte>& bytes);
void encode(const FetchAnswer& message, std::vector<std::byte>& bytes,
            ProtocolVersion version = kProtocolVersion);

[[nodiscard]] Decoded<FetchRequest> decode_fetch_request(std::span<const std::byte> bytes,
                                                         ProtocolVersion version = kProtocolVersion);
[[nodiscard]] Decoded<FetchAnswer> decode_fetch_answer(std::span<const std::byte> bytes);

}  // namespace farshade
