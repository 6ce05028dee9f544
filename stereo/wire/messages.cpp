// Each message has one field list, read and written by the same function, and one statement of its ranges,
// which foreign bytes are refused by and our own messages are checked against.
#include "stereo/wire/messages.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <type_traits>

#include "stereo/frame/tiles.h"
#include "stereo/wire/bytes.h"

namespace farshade {
namespace {

constexpr std::uint32_t kMagic = 0x48534446;                 // "FDSH" in byte order
constexpr std::int64_t kMaxTime_ns = std::int64_t{1} << 61;  // 73 years: sums and differences cannot overflow
constexpr double kMaxCoordinate_m = 1e9;

struct Header {
  std::uint32_t magic = kMagic;
  std::uint16_t version = kProtocolVersion;
  std::uint8_t type = 0;
};

template <class Message>
constexpr std::uint8_t kTypeOf = 0;
template <>
constexpr std::uint8_t kTypeOf<Hello> = 1;
template <>
constexpr std::uint8_t kTypeOf<RequestMessage> = 2;
template <>
constexpr std::uint8_t kTypeOf<Welcome> = 16;
template <>
constexpr std::uint8_t kTypeOf<Refusal> = 17;
template <>
constexpr std::uint8_t kTypeOf<Slice> = 18;
template <>
constexpr std::uint8_t kTypeOf<FrameReport> = 19;

/// No version changes the layout of these: their version is the sender's, in the header.
template <class Message>
concept InEveryVersion = std::same_as<Message, Hello> || std::same_as<Message, Refusal>;

template <class Message>
Header header_of(const Message& message) {
  if constexpr (InEveryVersion<Message>) return {.version = message.version, .type = kTypeOf<Message>};
  return {.type = kTypeOf<Message>};
}

// ---- field lists: `io` is a ByteWriter and the message const, or a ByteReader. False: the bytes end early.

/// A message to be read, or one to be written.
template <class T, class Message>
concept Either = std::same_as<std::remove_const_t<T>, Message>;

bool fields(auto& io, Either<Header> auto& header) {
  return io.u32(header.magic) && io.u16(header.version) && io.u8(header.type);
}

bool fields(auto& io, Either<Extent> auto& size) {
  return io.u16(size.width) && io.u16(size.height);
}

bool fields(auto& io, Either<View> auto& view) {
  auto& q = view.stage_from_eye.rotation;
  auto& t = view.stage_from_eye.translation;
  auto& fov = view.fov;
  return io.f64(q.w) && io.f64(q.x) && io.f64(q.y) && io.f64(q.z) &&                     //
         io.f64(t.x) && io.f64(t.y) && io.f64(t.z) &&                                    //
         io.f64(fov.left) && io.f64(fov.right) && io.f64(fov.up) && io.f64(fov.down) &&  //
         fields(io, view.size);
}

bool fields(auto& io, Either<Hello> auto& hello) {
  return io.array(hello.scene_hash) && io.array(hello.reserved);
}

/// What the client holds travels as how far it lies behind the frame asked for; 0: none.
bool frames_behind_field(ByteWriter& io, const RequestMessage& message) {
  const std::optional<FrameId> newest = message.newest_received;
  return io.u32(newest ? message.request.frame.value - newest->value : 0u);
}
bool frames_behind_field(ByteReader& io, RequestMessage& message) {
  std::uint32_t behind = 0;
  if (!io.u32(behind)) return false;
  if (behind != 0) message.newest_received = FrameId{message.request.frame.value - behind};
  return true;
}

bool fields(auto& io, Either<RequestMessage> auto& message) {
  auto& request = message.request;
  return io.u32(request.frame.value) && frames_behind_field(io, message) &&  //
         io.ns(request.display_time) && io.ns(request.scene_time) &&         //
         fields(io, request.views[0]) && fields(io, request.views[1]);
}

bool fields(auto& io, Either<Welcome> auto& welcome) {
  return io.array(welcome.scene_hash) && io.u16(welcome.light_count) && io.u32(welcome.light_set_revision);
}

bool fields(auto& io, Either<Refusal> auto& refusal) {
  return io.code(refusal.reason) && io.array(refusal.scene_hash);
}

bool fields(auto& io, Either<Slice> auto& slice) {
  return io.u32(slice.frame.value) && io.u32(slice.light_set_revision) && io.code(slice.eye) &&
         fields(io, slice.size) && io.u16(slice.lights) && io.u8(slice.plane) && io.u32(slice.first_tile) &&
         io.u16(slice.tile_count) && io.rest(slice.block);
}

bool fields(auto& io, Either<FrameReport> auto& report) {
  return io.u32(report.frame.value) && io.u32(report.slices) && io.u32(report.payload_bytes) &&
         io.u64(report.primary_rays) && io.u64(report.shadow_rays) && io.u64(report.full_shadow_rays) &&
         io.ns(report.primary) && io.ns(report.shadow) && io.ns(report.pack) && io.ns(report.waited) &&
         io.u32(report.superseded);
}

// ---- ranges: why a message may not be sent and is refused

using Verdict = std::optional<WireRefusal>;
constexpr Verdict kFine = std::nullopt;

bool in_range(Time time) {
  return ns_of(time) >= -kMaxTime_ns && ns_of(time) <= kMaxTime_ns;
}
bool in_range(Duration span) {
  return span.count() >= 0 && span.count() <= kMaxTime_ns;
}

bool in_range(const View& view) {
  const glm::dvec3& t = view.stage_from_eye.translation;
  return is_valid(view) && std::max({std::abs(t.x), std::abs(t.y), std::abs(t.z)}) <= kMaxCoordinate_m;
}

Verdict verdict(const Hello& hello) {
  if (hello.reserved != decltype(hello.reserved){}) return WireRefusal::Code;
  return kFine;
}

Verdict verdict(const RequestMessage& message) {
  const TraceRequest& request = message.request;
  if (message.newest_received && !is_newer(request.frame, *message.newest_received))
    return WireRefusal::FrameOrder;
  if (!in_range(request.display_time) || !in_range(request.scene_time)) return WireRefusal::TimeRange;
  if (!in_range(request.views[0]) || !in_range(request.views[1])) return WireRefusal::ViewRange;
  return kFine;
}

Verdict verdict(const Welcome& welcome) {
  if (welcome.light_count > kMaxLights) return WireRefusal::Lights;
  return kFine;
}

Verdict verdict(const Refusal& refusal) {
  if (refusal.reason < RefusalReason::VersionMismatch || refusal.reason > RefusalReason::NotWelcomed)
    return WireRefusal::Code;
  return kFine;
}

Verdict verdict(const Slice& slice) {
  const auto side_fits = [](std::uint32_t side) { return side >= 1 && side <= kMaxViewSide_px; };
  if (slice.eye != Side::Left && slice.eye != Side::Right) return WireRefusal::Code;
  if (!side_fits(slice.size.width) || !side_fits(slice.size.height)) return WireRefusal::MaskSize;
  if (slice.lights > kMaxLights || slice.plane >= MaskLayout{slice.lights}.planes())
    return WireRefusal::Lights;
  const std::uint32_t tiles = TileGrid{slice.size}.count();
  if (slice.tile_count == 0 || slice.first_tile >= tiles || slice.tile_count > tiles - slice.first_tile)
    return WireRefusal::TileRange;
  return kFine;
}

Verdict verdict(const FrameReport& report) {
  const bool fine =
      in_range(report.primary) && in_range(report.shadow) && in_range(report.pack) && in_range(report.waited);
  return fine ? kFine : WireRefusal::TimeRange;
}

// ---- whole datagrams

template <class... Messages>
void encode_any(const std::variant<Messages...>& any, std::vector<std::byte>& datagram) {
  datagram.clear();
  ByteWriter io(datagram);
  std::visit(
      [&io](const auto& message) {
        check(!verdict(message), "a message is within its ranges before it is sent");
        const Header header = header_of(message);
        fields(io, header);
        fields(io, message);
      },
      any);
  check(datagram.size() <= kMaxDatagram_bytes, "a message fits into a datagram");
}

template <class Any, class Message>
Decoded<Any> decode_as(ByteReader io, const Header& header) {
  Message message{};
  if constexpr (InEveryVersion<Message>)
    message.version = header.version;
  else if (header.version != kProtocolVersion)
    return refuse(WireRefusal::Version);
  if (!fields(io, message)) return refuse(WireRefusal::Truncated);
  if (const Verdict why = verdict(message)) return refuse(*why);
  if (io.remaining() > 0) return refuse(WireRefusal::TrailingBytes);
  return message;
}

template <class... Messages>
Decoded<std::variant<Messages...>> decode_any(std::span<const std::byte> datagram) {
  using Any = std::variant<Messages...>;
  if (datagram.size() > kMaxDatagram_bytes) return refuse(WireRefusal::TooLong);
  ByteReader io(datagram);
  Header header;
  if (!fields(io, header)) return refuse(WireRefusal::Truncated);
  if (header.magic != kMagic) return refuse(WireRefusal::Magic);
  Decoded<Any> decoded =
      refuse(header.version == kProtocolVersion ? WireRefusal::Type : WireRefusal::Version);
  static_cast<void>(
      ((header.type == kTypeOf<Messages> && (decoded = decode_as<Any, Messages>(io, header), true)) || ...));
  return decoded;
}

}  // namespace

void encode(const ClientMessage& message, std::vector<std::byte>& datagram) {
  encode_any(message, datagram);
}
void encode(const ServerMessage& message, std::vector<std::byte>& datagram) {
  encode_any(message, datagram);
}

Decoded<ClientMessage> decode_client(std::span<const std::byte> datagram) {
  return decode_any<Hello, RequestMessage>(datagram);
}

Decoded<ServerMessage> decode_server(std::span<const std::byte> datagram) {
  return decode_any<Welcome, Refusal, Slice, FrameReport>(datagram);
}

}  // namespace farshade
