// Each message has one field list, which both reads and writes it, and one function that checks its ranges:
// for foreign bytes, which are refused, and for our own messages, where a failure is a bug.
#include "stereo/messages/messages.h"

#include <algorithm>
#include <limits>

#include "stereo/frame/tiles.h"
#include "stereo/messages/frame_fields.h"
#include "stereo/messages/message_codec.h"

namespace farshade {

namespace codec {
template <>
inline constexpr std::uint8_t kTypeOf<RequestMessage> = 1;
template <>
inline constexpr std::uint8_t kTypeOf<AskSlice> = 2;
template <>
inline constexpr std::uint8_t kTypeOf<Leave> = 3;
template <>
inline constexpr std::uint8_t kTypeOf<Welcome> = 16;
template <>
inline constexpr std::uint8_t kTypeOf<Refusal> = 17;
template <>
inline constexpr std::uint8_t kTypeOf<Slice> = 18;
template <>
inline constexpr std::uint8_t kTypeOf<FrameReport> = 19;
template <>
inline constexpr std::uint8_t kTypeOf<Probe> = 20;
template <>
inline constexpr std::uint8_t kTypeOf<PlaneSlice> = 21;
template <>
inline constexpr std::uint8_t kTypeOf<VideoPart> = 22;
template <>
inline constexpr std::uint8_t kTypeOf<Goodbye> = 23;
template <>
inline constexpr std::uint8_t kTypeOf<PathProbe> = 26;
}  // namespace codec

using codec::Either;
using codec::kFine;
using codec::Verdict;

// ---- field lists: `io` is a ByteWriter and the message const, or a ByteReader. They return false if the
// bytes end early. They are not in the anonymous namespace, since the codec finds them by argument-dependent
// lookup.

/// The newest frame that the client has is sent as its distance to the requested frame; 0: it has none.
bool frames_behind_field(ByteWriter& io, const RequestMessage& message) {
  const std::optional<FrameId> newest = message.newest_received;
  return io.u32(newest ? message.request.frame.value - newest->value : 0u);
}
bool frames_behind_field(Reader auto& io, RequestMessage& message) {
  std::uint32_t behind = 0;
  if (!io.u32(behind)) return false;
  if (behind != 0) message.newest_received = FrameId{message.request.frame.value - behind};
  return true;
}

bool fields(ByteWriter& io, const LightChanges& changes) {
  bool fine = io.u32(changes.revision.value) && io.u8(changes.lights.size());
  for (const LightChange& change : changes.lights) fine = fine && fields(io, change);
  return fine;
}
bool fields(Reader auto& io, LightChanges& changes) {
  std::uint8_t count = 0;
  if (!io.u32(changes.revision.value) || !io.u8(count)) return false;
  // Reads one more than allowed, so that the range check sees that there are too many.
  const std::size_t most = RequestMessage::kMostLightChanges + 1;
  for (std::size_t i = 0; i < std::min<std::size_t>(count, most); ++i)
    if (!fields(io, changes.lights.emplace_back())) return false;
  return true;
}

bool fields(auto& io, Either<ArrivalReport> auto& report) {
  if (!io.u64(report.first) || !io.ns(report.base) || !io.u16(report.count)) return false;
  bool fine = true;
  for (std::size_t i = 0; i < std::min<std::size_t>(report.count, ArrivalReport::kMost); ++i)
    fine = fine && io.u16(report.ticks[i]);
  return fine;
}

bool fields(auto& io, Either<AnswerSpec> auto& spec) {
  return io.code(spec.kind) && io.u32(spec.bits_per_second) && io.ns(spec.interval) && io.code(spec.coding) &&
         io.u8(spec.position_bits) && io.u16(spec.slices);
}

bool fields(auto& io, Either<RequestMessage> auto& message) {
  auto& request = message.request;
  return io.u32(request.frame.value) && frames_behind_field(io, message) &&  //
         io.ns(request.display_time) && io.ns(request.scene_time) &&         //
         fields(io, request.views[0]) && fields(io, request.views[1]) &&     //
         fields(io, request.answer) &&                                       //
         io.u64(message.probe_echo) && fields(io, request.lights) && fields(io, message.arrivals);
}

bool fields(auto& io, Either<AskSlice> auto& slice) {
  return io.u32(slice.frame.value) && io.code(slice.eye) && fields(io, slice.size) && io.u16(slice.lights) &&
         io.u32(slice.first_tile) && io.u16(slice.tile_count) && io.rest(slice.block);
}

bool fields(auto& io, Either<Welcome> auto& welcome) {
  return io.array(welcome.scene_hash) && io.u16(welcome.light_count) && io.u32(welcome.most_pixels) &&
         io.u8(welcome.answers) && fields(io, welcome.exposure);
}

bool fields(auto& io, Either<Refusal> auto& refusal) {
  return io.code(refusal.reason) && io.array(refusal.scene_hash);
}

bool fields(auto& io, Either<Slice> auto& slice) {
  return io.u32(slice.frame.value) && io.u32(slice.light_set_revision.value) && io.code(slice.eye) &&
         fields(io, slice.size) && io.u16(slice.lights) && io.u8(slice.plane) && io.u32(slice.first_tile) &&
         io.u16(slice.tile_count) && io.rest(slice.block);
}

bool fields(auto& io, Either<FrameReport> auto& report) {
  return io.u32(report.frame.value) && io.u32(report.slices) && io.u32(report.payload_bytes) &&
         io.u64(report.primary_rays) && io.u64(report.shadow_rays) && io.u64(report.full_shadow_rays) &&
         io.ns(report.update) && io.ns(report.primary) && io.ns(report.shadow) && io.ns(report.draw) &&
         io.ns(report.pack) && io.ns(report.waited) && io.u32(report.superseded) &&
         io.u32(report.bytes_per_second) && io.u8(report.view_scale.eighths);
}

bool fields(auto& io, Either<PlaneSlice> auto& slice) {
  return io.u32(slice.frame.value) && io.code(slice.eye) && io.code(slice.kind) && fields(io, slice.size) &&
         io.u8(slice.word_bytes) && io.u32(slice.first_tile) && io.u16(slice.tile_count) &&
         io.rest(slice.block);
}

bool fields(auto& io, Either<VideoPart> auto& part) {
  return io.u32(part.frame.value) && io.u32(part.after.value) && io.u16(part.part) && io.u16(part.parts) &&
         io.rest(part.bytes);
}

bool fields(auto& io, Either<Probe> auto& probe) {
  return io.u64(probe.token);
}

bool fields(auto&, Either<Leave> auto&) {
  return true;
}

bool fields(auto& io, Either<Goodbye> auto& goodbye) {
  return io.code(goodbye.reason);
}

bool fields(auto& io, Either<PathProbe> auto& probe) {
  return io.rest(probe.padding);
}

// ---- ranges: the reason to refuse a message

Verdict verdict(const LightChanges& changes) {
  if (changes.lights.size() > RequestMessage::kMostLightChanges) return WireRefusal::Lights;
  LightSetRevision last = kFirstLightSet;
  for (const LightChange& change : changes.lights) {
    if (const Verdict why = verdict_on(change, last, changes.revision)) return why;
    last = change.revision;
  }
  return kFine;
}

Verdict verdict(const ArrivalReport& report) {
  if (report.count > ArrivalReport::kMost) return WireRefusal::Arrivals;
  if (report.first > std::numeric_limits<std::uint64_t>::max() / 2) return WireRefusal::Arrivals;
  return in_range(report.base) ? kFine : WireRefusal::TimeRange;
}

/// Fields that an answer does not use must be 0.
Verdict verdict(const AnswerSpec& spec) {
  if (static_cast<std::uint8_t>(spec.kind) >= kAnswers) return WireRefusal::Code;
  if (spec.coding > Coding::Lz4) return WireRefusal::Code;
  const bool video = is_video(spec.kind), positions = spec.kind == Answer::MasksOfPositions;
  const bool coding = spec.coding == Coding::Lz4 ? spec.kind == Answer::Masks && spec.slices == 0
                                                 : video || spec.coding == Coding::AfterLast;
  const bool rate = video
                        ? spec.bits_per_second >= kLeastVideo_bits && spec.bits_per_second <= kMostVideo_bits
                        : spec.bits_per_second == 0;
  const bool interval = video ? spec.interval > Duration::zero() && spec.interval <= kMostPictureInterval
                              : spec.interval == Duration::zero();
  const bool grid =
      positions ? spec.position_bits >= kLeastPosition_bits && spec.position_bits <= kMostPosition_bits
                : spec.position_bits == 0;
  const bool slices = positions || spec.kind == Answer::Masks || spec.slices == 0;
  return coding && rate && interval && grid && slices ? kFine : WireRefusal::AnswerSpec;
}

Verdict verdict(const RequestMessage& message) {
  const FrameRequest& request = message.request;
  if (message.newest_received && !is_newer(request.frame, *message.newest_received))
    return WireRefusal::FrameOrder;
  if (!in_range(request.display_time) || !in_range(request.scene_time)) return WireRefusal::TimeRange;
  if (!in_range(request.views[0]) || !in_range(request.views[1])) return WireRefusal::ViewRange;
  if (const Verdict why = verdict(request.answer)) return why;
  if (const Verdict why = verdict(request.lights)) return why;
  return verdict(message.arrivals);
}

Verdict verdict(const Welcome& welcome) {
  if (welcome.light_count > kMaxLights) return WireRefusal::Lights;
  if (welcome.most_pixels == 0) return WireRefusal::MaskSize;
  if (welcome.answers > kEveryAnswer) return WireRefusal::Code;
  if (!in_range(welcome.exposure)) return WireRefusal::Code;
  return kFine;
}

Verdict verdict(const Refusal& refusal) {
  const bool known = refusal.reason == RefusalReason::SceneMismatch || refusal.reason == RefusalReason::Busy;
  return known ? kFine : WireRefusal::Code;
}

/// Checks the fields that all slices have: eye, size and tiles.
Verdict verdict_on_tiles(const auto& slice) {
  const auto side_fits = [](std::uint32_t side) { return side >= 1 && side <= kMaxViewSide_px; };
  if (slice.eye != Side::Left && slice.eye != Side::Right) return WireRefusal::Code;
  if (!side_fits(slice.size.width) || !side_fits(slice.size.height)) return WireRefusal::MaskSize;
  const std::uint32_t tiles = TileGrid{slice.size}.count();
  if (slice.tile_count == 0 || slice.first_tile >= tiles || slice.tile_count > tiles - slice.first_tile)
    return WireRefusal::TileRange;
  return kFine;
}

Verdict verdict(const AskSlice& slice) {
  if (const Verdict why = verdict_on_tiles(slice)) return why;
  return slice.lights <= kMaxLights ? kFine : WireRefusal::Lights;
}

Verdict verdict(const Slice& slice) {
  if (const Verdict why = verdict_on_tiles(slice)) return why;
  if (slice.lights > kMaxLights || slice.plane >= MaskLayout{slice.lights}.planes())
    return WireRefusal::Lights;
  return kFine;
}

Verdict verdict(const PlaneSlice& slice) {
  if (slice.kind > PlaneKind::PositionZ) return WireRefusal::Code;
  if (slice.word_bytes < 1 || slice.word_bytes > kMaxPlaneWord_bytes) return WireRefusal::Code;
  return verdict_on_tiles(slice);
}

Verdict verdict(const VideoPart& part) {
  if (is_newer(part.after, part.frame)) return WireRefusal::FrameOrder;
  const bool is_last = part.part + 1 == part.parts;
  const bool fine = part.parts >= 1 && part.parts <= kMostVideoParts && part.part < part.parts &&
                    !part.bytes.empty() && part.bytes.size() <= kVideoPart_bytes &&
                    (is_last || part.bytes.size() == kVideoPart_bytes);
  return fine ? kFine : WireRefusal::Part;
}

Verdict verdict(const FrameReport& report) {
  const bool fine = in_range(report.update) && in_range(report.primary) && in_range(report.shadow) &&
                    in_range(report.draw) && in_range(report.pack) && in_range(report.waited);
  if (!fine) return WireRefusal::TimeRange;
  return is_valid(report.view_scale) ? kFine : WireRefusal::Code;
}

Verdict verdict(const Leave&) {
  return kFine;
}

Verdict verdict(const Goodbye& goodbye) {
  return goodbye.reason >= EndReason::ServerEnds && goodbye.reason <= EndReason::Withdrawn
             ? kFine
             : WireRefusal::Code;
}

Verdict verdict(const Probe& probe) {
  return probe.token != 0 ? kFine : WireRefusal::Code;
}

Verdict verdict(const PathProbe& probe) {
  const bool fine = !probe.padding.empty() &&
                    std::ranges::all_of(probe.padding, [](std::byte byte) { return byte == std::byte{0}; });
  return fine ? kFine : WireRefusal::Padding;
}

// ---- whole messages

void encode(const ClientMessage& message, std::vector<std::byte>& bytes, ProtocolVersion version) {
  codec::encode_any(message, kBaseMessage_bytes, bytes, version);
}
void encode(const ServerMessage& message, std::vector<std::byte>& bytes, ProtocolVersion version) {
  codec::encode_any(message, kMaxMessage_bytes, bytes, version);
}

Decoded<ClientMessage> decode_client(std::span<const std::byte> bytes, ProtocolVersion version) {
  return codec::decode_any<ClientMessage>(bytes, kBaseMessage_bytes, version);
}

Decoded<ServerMessage> decode_server(std::span<const std::byte> bytes, ProtocolVersion version) {
  return codec::decode_any<ServerMessage>(bytes, kMaxMessage_bytes, version);
}

void record_messages(LayoutRecorder& io) {
  codec::record_any(std::type_identity<ClientMessage>{}, io);
  codec::record_any(std::type_identity<ServerMessage>{}, io);
}

}  // namespace farshade
