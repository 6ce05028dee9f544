// Each kind of record has one function that lists its fields for reading and writing, and one function that
// checks their ranges. Within these ranges a replay cannot overflow.
#include "vr_client/record/capture_file.h"

#include <sodium.h>
#include <zlib.h>

#include <algorithm>
#include <bitset>

#include "stereo/messages/frame_fields.h"

namespace farshade {

using codec::Either;
using codec::kFine;
using codec::Verdict;

namespace {

constexpr Duration kLongestPeriod = std::chrono::seconds(1000);
constexpr std::uint32_t kMaxEvery = 1024, kMaxFramesInFlight = 4096;
constexpr double kMaxRefresh_hz = 1e6;

bool text_field(ByteWriter& io, const std::string& text) {
  io.u8(text.size());
  return io.rest(std::as_bytes(std::span(text)));
}
bool text_field(ByteReader& io, std::string& text) {
  std::uint8_t size = 0;
  if (!io.u8(size) || io.remaining() < size) return false;
  text.resize(size);
  for (char& c : text) {
    std::uint8_t byte = 0;
    io.u8(byte);
    c = static_cast<char>(byte);
  }
  return true;
}

bool light_fields(ByteWriter& io, const LightChanges& changes) {
  bool fine = io.u32(changes.revision.value) && io.u16(changes.lights.size());
  for (const LightChange& change : changes.lights) fine = fine && fields(io, change);
  return fine;
}
/// The vector grows with the bytes that are present, not with the count that the file states.
bool light_fields(ByteReader& io, LightChanges& changes) {
  std::uint16_t count = 0;
  if (!io.u32(changes.revision.value) || !io.u16(count)) return false;
  for (std::size_t i = 0; i < count; ++i)
    if (!fields(io, changes.lights.emplace_back())) return false;
  return true;
}

bool settings_fields(auto& io, Either<FrameSettings> auto& settings) {
  return io.code(settings.request.predictor) && io.code(settings.request.guard_band) &&
         io.u32(settings.request.every) && io.u32(settings.request.guard_band_percent) &&
         io.code(settings.reprojection.lookup) && io.code(settings.reprojection.eyes) &&
         io.code(settings.reprojection.gaps) && io.code(settings.reprojection.edges) &&
         io.code(settings.scene) && light_fields(io, settings.lights);
}

// ---- Ranges

bool in_range(Extent size) {
  const auto fits = [](std::uint32_t side) { return side >= 1 && side <= kMaxViewSide_px; };
  return fits(size.width) && fits(size.height);
}

bool is_plain(const std::string& text) {
  return text.size() <= kMaxCaptureText_bytes &&
         std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f; });
}

template <class Enum>
bool is_one_of(Enum value, Enum last) {
  return static_cast<int>(value) >= 0 && value <= last;
}

Verdict verdict_on_lights(const LightChanges& changes) {
  std::bitset<kMaxLights> seen;
  LightSetRevision last = kFirstLightSet;
  for (const LightChange& change : changes.lights) {
    if (const Verdict why = verdict_on(change, last, changes.revision)) return why;
    if (seen.test(change.light)) return WireRefusal::Lights;
    seen.set(change.light);
    last = change.revision;
  }
  return kFine;
}

Verdict verdict_on(const FrameSettings& settings) {
  const bool codes =
      std::ranges::find(kPredictorKinds, settings.request.predictor) != std::end(kPredictorKinds) &&
      is_one_of(settings.request.guard_band, GuardBandUse::Measured) && settings.request.every <= kMaxEvery &&
      settings.request.guard_band_percent <= kWidestBand_percent &&
      is_one_of(settings.reprojection.lookup, Lookup::Direct) &&
      is_one_of(settings.reprojection.eyes, Eyes::Both) &&
      is_one_of(settings.reprojection.gaps, Gaps::Neighbours) &&
      is_one_of(settings.reprojection.edges, Edges::Coverage) &&
      is_one_of(settings.scene, SceneClock::Paused);
  return codes ? verdict_on_lights(settings.lights) : WireRefusal::Code;
}

/// Fields of a Request or Received record before its message is decoded.
struct TimedMessage {
  Time time;
  std::span<const std::byte> bytes;
};

struct PicturesRecord {
  PerEye<PictureHash> pictures{};
};

}  // namespace

// These functions are outside the anonymous namespace because the codec finds them by argument-dependent
// lookup.

bool fields(auto& io, Either<CaptureHeader> auto& header) {
  auto& limits = header.limits;  // but for `frames`: a replay waits for each frame
  auto& policy = header.policy;
  return text_field(io, header.scene) && io.array(header.scene_hash) && io.u16(header.lights) &&
         io.code(header.origin) && fields(io, limits.size) && fields(io, limits.traced_size) &&
         io.u32(limits.depth_frames) && io.f64(header.detail_px) && io.u32(header.requests) &&
         io.f64(header.refresh_hz) && fields(io, header.exposure) && io.code(policy.pace) &&
         io.ns(policy.delay) && io.ns(policy.round_trip) && io.ns(policy.mask_wait) &&
         text_field(io, header.device);
}

bool fields(auto& io, Either<CapturedFrameInput> auto& input) {
  return io.ns(input.timing.display_time) && io.ns(input.timing.period) && look_fields(io, input.views[0]) &&
         look_fields(io, input.views[1]) && settings_fields(io, input.settings);
}

bool fields(auto& io, Either<CaptureEnd> auto& end) {
  return io.u32(end.frames);
}

namespace {
bool fields(auto& io, Either<TimedMessage> auto& timed) {
  return io.ns(timed.time) && io.rest(timed.bytes);
}
bool fields(auto& io, Either<PicturesRecord> auto& record) {
  return io.array(record.pictures[0]) && io.array(record.pictures[1]);
}
Verdict verdict(const TimedMessage& timed) {
  return in_range(timed.time) ? kFine : Verdict(WireRefusal::TimeRange);
}
Verdict verdict(const PicturesRecord&) {
  return kFine;
}
}  // namespace

Verdict verdict(const CaptureHeader& header) {
  const RendererLimits& limits = header.limits;
  if (!is_plain(header.scene) || !is_plain(header.device)) return WireRefusal::Code;
  if (!is_one_of(header.origin, MaskOrigin::OwnTracer) || !is_one_of(header.policy.pace, Pace::Real))
    return WireRefusal::Code;
  if (header.lights > kMaxLights) return WireRefusal::Lights;
  const bool sized = in_range(limits.size) &&
                     (limits.traced_size == limits.size || limits.traced_size == largest_traced(limits.size));
  if (!sized) return WireRefusal::MaskSize;
  if (!(header.detail_px >= 0 && header.detail_px <= double{kMostDetail_px})) return WireRefusal::ViewRange;
  const bool counted = limits.depth_frames >= 1 && limits.depth_frames <= kMaxFramesInFlight &&
                       header.requests > Assembler::kKept && header.requests <= kMaxFramesInFlight;
  if (!counted) return WireRefusal::FrameOrder;
  const bool timed = header.refresh_hz > 0 && header.refresh_hz <= kMaxRefresh_hz &&
                     in_range(header.policy.delay) && in_range(header.policy.round_trip) &&
                     in_range(header.policy.mask_wait);
  if (!in_range(header.exposure)) return WireRefusal::Code;
  return timed ? kFine : Verdict(WireRefusal::TimeRange);
}

Verdict verdict(const CaptureEnd&) {
  return kFine;
}

Verdict verdict(const CapturedFrameInput& input) {
  const FrameTiming& timing = input.timing;
  if (!in_range(timing.display_time) || timing.period <= Duration::zero() || timing.period > kLongestPeriod)
    return WireRefusal::TimeRange;
  for (const View& view : input.views)
    if (!in_range(view.stage_from_eye.translation) || !is_valid(view)) return WireRefusal::ViewRange;
  return verdict_on(input.settings);
}

namespace {

/// Kind and length, then the fields and the checksum.
template <class Record>
void append_record(RecordKind kind, const Record& record, std::vector<std::byte>& file) {
  check(!verdict(record), "a record that is written is within its ranges");
  std::vector<std::byte> body;
  ByteWriter fields_of(body);
  fields(fields_of, record);
  check(body.size() <= kMaxRecord_bytes, "a record that is written has at most kMaxRecord_bytes");
  const std::size_t begin = file.size();
  ByteWriter io(file);
  io.code(kind);
  io.u32(body.size());
  io.rest(body);
  io.u32(checksum_of(std::span(file).subspan(begin)));
}

std::string plain(std::string text) {
  text.resize(std::min(text.size(), kMaxCaptureText_bytes));
  std::ranges::replace_if(
      text, [](char c) { return !is_plain({c}); }, '?');
  return text;
}

void append_received(const std::vector<CapturedMessage>& messages, std::vector<std::byte>& file) {
  for (const CapturedMessage& message : messages)
    append_record(RecordKind::Received, TimedMessage{message.arrived, message.bytes}, file);
}

}  // namespace

void append(const CaptureHeader& header, std::vector<std::byte>& file) {
  ByteWriter io(file);
  io.u32(kCaptureMagic);
  io.u16(kCaptureVersion);
  io.u16(kProtocolVersion);
  CaptureHeader written = header;
  written.scene = plain(header.scene);
  written.device = plain(header.device);
  append_record(RecordKind::Header, written, file);
}

void append(const CapturedFrame& frame, std::vector<std::byte>& file) {
  append_record(RecordKind::Frame, frame.input, file);
  append_received(frame.before, file);
  if (frame.request) {
    std::vector<std::byte> message;
    encode(ClientMessage(RequestMessage{.request = frame.request->request}), message);
    append_record(RecordKind::Request, TimedMessage{frame.request->sent, message}, file);
  }
  append_received(frame.after, file);
  append_record(RecordKind::Pictures, PicturesRecord{frame.pictures}, file);
}

void append(const CaptureEnd& end, std::vector<std::byte>& file) {
  append_record(RecordKind::End, end, file);
}

std::uint32_t checksum_of(std::span<const std::byte> record) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const unsigned char*>(record.data()), record.size()));
}

Decoded<CaptureHeader> decode_header(std::span<const std::byte> bytes) {
  return codec::read<CaptureHeader>(ByteReader(bytes));
}

Decoded<CapturedFrameInput> decode_frame(std::span<const std::byte> bytes, Extent eye_size) {
  CapturedFrameInput input;
  for (View& view : input.views) view.size = eye_size;
  ByteReader io(bytes);
  if (!fields(io, input)) return refuse(WireRefusal::Truncated);
  if (const Verdict why = verdict(input)) return refuse(*why);
  if (io.remaining() > 0) return refuse(WireRefusal::TrailingBytes);
  return input;
}

Decoded<CapturedMessage> decode_received(std::span<const std::byte> bytes) {
  const Decoded<TimedMessage> timed = codec::read<TimedMessage>(ByteReader(bytes));
  if (!timed) return refuse(timed.error());
  if (const Decoded<ServerMessage> message = decode_server(timed->bytes); !message)
    return refuse(message.error());
  return CapturedMessage{timed->time, {timed->bytes.begin(), timed->bytes.end()}};
}

Decoded<CapturedRequest> decode_request(std::span<const std::byte> bytes) {
  const Decoded<TimedMessage> timed = codec::read<TimedMessage>(ByteReader(bytes));
  if (!timed) return refuse(timed.error());
  Decoded<ClientMessage> message = decode_client(timed->bytes);
  if (!message) return refuse(message.error());
  auto* const request = std::get_if<RequestMessage>(&*message);
  if (!request) return refuse(WireRefusal::Type);
  return CapturedRequest{timed->time, std::move(request->request)};
}

Decoded<PerEye<PictureHash>> decode_pictures(std::span<const std::byte> bytes) {
  return codec::read<PicturesRecord>(ByteReader(bytes)).map([](const PicturesRecord& record) {
    return record.pictures;
  });
}

Decoded<CaptureEnd> decode_end(std::span<const std::byte> bytes) {
  return codec::read<CaptureEnd>(ByteReader(bytes));
}

PictureHash hash_of(const Image<Rgb8>& picture) {
  check(sodium_init() >= 0, "libsodium starts");
  std::vector<std::byte> size;
  ByteWriter io(size);
  io.u32(picture.size.width);
  io.u32(picture.size.height);
  PictureHash hash{};
  crypto_generichash_state state;
  const auto feed = [&](std::span<const std::byte> bytes) {
    crypto_generichash_update(&state, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  };
  crypto_generichash_init(&state, nullptr, 0, hash.size());
  feed(size);
  feed(std::as_bytes(std::span(picture.pixels)));
  crypto_generichash_final(&state, hash.data(), hash.size());
  return hash;
}

}  // namespace farshade
