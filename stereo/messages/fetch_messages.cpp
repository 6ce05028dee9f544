#include "stereo/messages/fetch_messages.h"

#include "stereo/messages/message_codec.h"

namespace farshade {

namespace codec {
template <>
inline constexpr std::uint8_t kTypeOf<OfferRequest> = 1;
template <>
inline constexpr std::uint8_t kTypeOf<ContentRequest> = 2;
template <>
inline constexpr std::uint8_t kTypeOf<OfferPart> = 16;
template <>
inline constexpr std::uint8_t kTypeOf<Content> = 17;
template <>
inline constexpr std::uint8_t kTypeOf<FetchRefusal> = 18;
}  // namespace codec

using codec::Either;
using codec::kFine;
using codec::Verdict;

bool fields(auto&, Either<OfferRequest> auto&) {
  return true;
}
bool fields(auto& io, Either<ContentRequest> auto& message) {
  return io.u64(message.begin) && io.u64(message.end);
}
bool fields(auto& io, Either<OfferPart> auto& message) {
  return io.code(message.more) && io.rest(message.bytes);
}
bool fields(auto& io, Either<Content> auto& message) {
  return io.u64(message.begin) && io.rest(message.bytes);
}
bool fields(auto& io, Either<FetchRefusal> auto& message) {
  return io.code(message);
}

Verdict verdict(const OfferRequest&) {
  return kFine;
}
Verdict verdict(const ContentRequest& m) {
  return m.begin < m.end ? kFine : WireRefusal::Code;
}
Verdict verdict(const OfferPart& m) {
  return m.more <= OfferPart::More::Yes && !m.bytes.empty() ? kFine : WireRefusal::Code;
}
Verdict verdict(const Content& m) {
  return !m.bytes.empty() ? kFine : WireRefusal::Code;
}
Verdict verdict(const FetchRefusal& m) {
  return m >= FetchRefusal::Busy && m <= FetchRefusal::Unreadable ? kFine : WireRefusal::Code;
}

void encode(const FetchRequest& message, std::vector<std::byte>& bytes) {
  codec::encode_any(message, kBaseMessage_bytes, bytes);
}
void encode(const FetchAnswer& message, std::vector<std::byte>& bytes, ProtocolVersion version) {
  codec::encode_any(message, kBaseMessage_bytes, bytes, version);
}

Decoded<FetchRequest> decode_fetch_request(std::span<const std::byte> bytes, ProtocolVersion version) {
  return codec::decode_any<FetchRequest>(bytes, kBaseMessage_bytes, version);
}
Decoded<FetchAnswer> decode_fetch_answer(std::span<const std::byte> bytes) {
  return codec::decode_any<FetchAnswer>(bytes, kBaseMessage_bytes);
}

void record_fetch_messages(LayoutRecorder& io) {
  codec::record_any(std::type_identity<FetchRequest>{}, io);
  codec::record_any(std::type_identity<FetchAnswer>{}, io);
}

}  // namespace farshade
