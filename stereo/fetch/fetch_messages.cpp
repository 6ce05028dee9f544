#include "stereo/fetch/fetch_messages.h"

#include "stereo/messages/bytes.h"

namespace farshade {
namespace {

enum class FetchType : std::uint8_t {
  OfferRequest = 1,
  ContentRequest = 2,
  OfferPart = 16,
  Content = 17,
  Refusal = 18
};

bool fetch_fields(auto&, OfferRequest&) {
  return true;
}
bool fetch_fields(auto& io, ContentRequest& message) {
  return io.u64(message.begin) && io.u64(message.end);
}
bool fetch_fields(auto& io, OfferPart& message) {
  return io.code(message.more) && io.rest(message.bytes);
}
bool fetch_fields(auto& io, Content& message) {
  return io.u64(message.begin) && io.rest(message.bytes);
}
bool fetch_fields(auto& io, FetchRefusal& message) {
  return io.code(message);
}

FetchType type_of(const OfferRequest&) {
  return FetchType::OfferRequest;
}
FetchType type_of(const ContentRequest&) {
  return FetchType::ContentRequest;
}
FetchType type_of(const OfferPart&) {
  return FetchType::OfferPart;
}
FetchType type_of(const Content&) {
  return FetchType::Content;
}
FetchType type_of(const FetchRefusal&) {
  return FetchType::Refusal;
}

bool is_in_range(const OfferRequest&) {
  return true;
}
bool is_in_range(const ContentRequest& m) {
  return m.begin < m.end;
}
bool is_in_range(const OfferPart& m) {
  return m.more <= OfferPart::More::Yes && !m.bytes.empty();
}
bool is_in_range(const Content& m) {
  return !m.bytes.empty();
}
bool is_in_range(const FetchRefusal& m) {
  return m >= FetchRefusal::Busy && m <= FetchRefusal::Unreadable;
}

void encode_any(const auto& messages, std::vector<std::byte>& bytes) {
  bytes.clear();
  ByteWriter io(bytes);
  std::visit(
      [&](auto message) {
        check(is_in_range(message), "the fields of a fetch message are in their ranges");
        io.code(type_of(message));
        fetch_fields(io, message);
      },
      messages);
  check(bytes.size() <= kBaseMessage_bytes, "a fetch message can be sealed");
}

template <class Any, class Message>
Decoded<Any> decode_as(ByteReader& io) {
  Message message{};
  if (!fetch_fields(io, message)) return refuse(WireRefusal::Truncated);
  if (!is_in_range(message)) return refuse(WireRefusal::Code);
  if (io.remaining() > 0) return refuse(WireRefusal::TrailingBytes);
  return Any(message);
}

}  // namespace

void encode(const FetchRequest& message, std::vector<std::byte>& bytes) {
  encode_any(message, bytes);
}

void encode(const FetchAnswer& message, std::vector<std::byte>& bytes) {
  encode_any(message, bytes);
}

Decoded<FetchRequest> decode_fetch_request(std::span<const std::byte> bytes) {
  ByteReader io(bytes);
  FetchType type{};
  if (!io.code(type)) return refuse(WireRefusal::Truncated);
  if (type == FetchType::OfferRequest) return decode_as<FetchRequest, OfferRequest>(io);
  if (type == FetchType::ContentRequest) return decode_as<FetchRequest, ContentRequest>(io);
  return refuse(WireRefusal::Type);
}

Decoded<FetchAnswer> decode_fetch_answer(std::span<const std::byte> bytes) {
  ByteReader io(bytes);
  FetchType type{};
  if (!io.code(type)) return refuse(WireRefusal::Truncated);
  if (type == FetchType::OfferPart) return decode_as<FetchAnswer, OfferPart>(io);
  if (type == FetchType::Content) return decode_as<FetchAnswer, Content>(io);
  if (type == FetchType::Refusal) return decode_as<FetchAnswer, FetchRefusal>(io);
  return refuse(WireRefusal::Type);
}

}  // namespace farshade
