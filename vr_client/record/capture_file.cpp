// Each kind of record has one field list, read and written by the same function, and one statement of its
// ranges. The ranges are those within which a session runs without overflow, whatever a file says.
#include "vr_client/record/capture_file.h"

#include <sodium.h>

#include <algorithm>
#include <bitset>

#include "stereo/wire/frame_fields.h"

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
  bool fine = io.u32(changes.revision) && io.u16(changes.lights.size());
  for (const LightChange& change : changes.lights) fine = fine && fields(io, change);
  return fine;
}
/// Grows with the bytes that are there, not with the count that they claim.
bool light_fields(ByteReader& io, LightChanges& changes) {
  std::uint16_t count = 0;
  if (!io.u32(changes.revision) || !io.u16(count)) return false;
  for (std::size_t i = 0; i < count; ++i)
    if (!fields(io, changes.lights.emplace_back())) return false;
  return true;
}

bool steering_fields(auto& io, Either<FrameSettings> auto& steering) {
  return io.code(steering.wish.predictor) && io.code(steering.wish.guard_band) &&
         io.u32(steering.wish.every) && io.u32(steering.wish.guard_band_percent) &&
         io.code(steering.carry_over.lookup) && io.code(steering.carry_over.eyes) &&
         io.code(steering.carry_over.gaps) && io.code(steering.carry_over.edges) && io.code(steering.scene) &&
         light_fields(io, steering.lights);
}

// ---- ranges

bool in_range(Extent size) {
  const auto fits = [](std::uint32_t side) { return side >= 1 && side <= kMaxViewSide_px; };
  return fits(size.width) && fits(size.height);
}

bool is_plain(const std::string& text) {
  return text.size() <= kMaxSessionText_bytes &&
         std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) >= 0x20 && c != 0x7f; });
}

template <class Enum>
bool is_one_of(Enum value, Enum last) {
  return static_cast<int>(value) >= 0 && value <= last;
}

Verdict verdict_on_lights(const LightChanges& changes) {
  std::bitset<kMaxLights> seen;
  std::uint32_t last = kFirstLightSet;
  for (const LightChange& change : changes.lights) {
    if (const Verdict why = verdict_on(change, last, changes.revision)) return why;
    if (seen.test(change.light)) return WireRefusal::Lights;
    seen.set(change.light);
    last = change.revision;
  }
  return kFine;
}

Verdict verdict_on(const FrameSettings& steering) {
  const bool codes =
      std::ranges::find(kPredictorKinds, steering.wish.predictor) != std::end(kPredictorKinds) &&
      is_one_of(steering.wish.guard_band, GuardBandUse::Measured) && steering.wish.every >= 1 &&
      steering.wish.every <= kMaxEvery && steering.wish.guard_band_percent <= kWidestBand_percent &&
      is_one_of(steering.carry_over.lookup, Lookup::Direct) &&
      is_one_of(steering.carry_over.eyes, Eyes::Both) &&
      is_one_of(steering.carry_over.gaps, Gaps::Neighbours) &&
      is_one_of(steering.carry_over.edges, Edges::Filtered) && is_one_of(steering.scene, SceneClock::Stands);
  return codes ? verdict_on_lights(steering.lights) : WireRefusal::Code;
}

/// An Asked record before its message is decoded, a Heard one likewise.
struct DatedBytes {
  Time time;
  std::span<const std::byte> bytes;
};

struct ShownRecord {
  PerEye<PictureHash> pictures{};
};

}  // namespace

// Not in the anonymous namespace: the codec finds them by their arguments.

bool fields(auto& io, Either<CaptureHeader> auto& header) {
  auto& [size, traced_size, depth_frames] = header.limits;
  auto& policy = header.policy;
  return text_field(io, header.scene) && io.array(header.scene_hash) && io.u16(header.lights) &&
         io.code(header.origin) && fields(io, size) && fields(io, traced_size) && io.u32(depth_frames) &&
         io.u32(header.requests) && io.f64(header.refresh_hz) && io.code(policy.pace) &&
         io.ns(policy.delay) && io.ns(policy.round_trip) && io.ns(policy.mask_wait) &&
         text_field(io, header.device);
}

bool fields(auto& io, Either<CapturedFrameInput> auto& input) {
  return io.ns(input.timing.display_time) && io.ns(input.timing.period) && look_fields(io, input.views[0]) &&
         look_fields(io, input.views[1]) && steering_fields(io, input.steering);
}

namespace {
bool fields(auto& io, Either<DatedBytes> auto& dated) {
  return io.ns(dated.time) && io.rest(dated.bytes);
}
bool fields(auto& io, Either<ShownRecord> auto& shown) {
  return io.array(shown.pictures[0]) && io.array(shown.pictures[1]);
}
Verdict verdict(const DatedBytes& dated) {
  return in_range(dated.time) ? kFine : Verdict(WireRefusal::TimeRange);
}
Verdict verdict(const ShownRecord&) {
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
  const bool counted = limits.depth_frames >= 1 && limits.depth_frames <= kMaxFramesInFlight &&
                       header.requests > Assembler::kKept && header.requests <= kMaxFramesInFlight;
  if (!counted) return WireRefusal::FrameOrder;
  const bool timed = header.refresh_hz > 0 && header.refresh_hz <= kMaxRefresh_hz &&
                     in_range(header.policy.delay) && in_range(header.policy.round_trip) &&
                     in_range(header.policy.mask_wait);
  return timed ? kFine : Verdict(WireRefusal::TimeRange);
}

Verdict verdict(const CapturedFrameInput& input) {
  const FrameTiming& timing = input.timing;
  if (!in_range(timing.display_time) || timing.period <= Duration::zero() || timing.period > kLongestPeriod)
    return WireRefusal::TimeRange;
  for (const View& view : input.views)
    if (!in_range(view.stage_from_eye.translation) || !is_valid(view)) return WireRefusal::ViewRange;
  return verdict_on(input.steering);
}

namespace {

/// The record's head, then its fields.
template <class Record>
void append_record(RecordKind kind, const Record& record, std::vector<std::byte>& file) {
  check(!verdict(record), "a record is within its ranges before it is written");
  std::vector<std::byte> body;
  ByteWriter fields_of(body);
  fields(fields_of, record);
  check(body.size() <= kMaxRecord_bytes, "a record is no longer than any may be");
  ByteWriter io(file);
  io.code(kind);
  io.u32(body.size());
  io.rest(body);
}

std::string plain(std::string text) {
  text.resize(std::min(text.size(), kMaxSessionText_bytes));
  std::ranges::replace_if(
      text, [](char c) { return !is_plain({c}); }, '?');
  return text;
}

void append_heard(const std::vector<CapturedMessage>& all, std::vector<std::byte>& file) {
  for (const CapturedMessage& heard : all)
    append_record(RecordKind::Heard, DatedBytes{heard.arrived, heard.bytes}, file);
}

}  // namespace

void append(const CaptureHeader& header, std::vector<std::byte>& file) {
  ByteWriter io(file);
  io.u32(kSessionMagic);
  io.u16(kSessionVersion);
  io.u16(kProtocolVersion);
  CaptureHeader written = header;
  written.scene = plain(header.scene);
  written.device = plain(header.device);
  append_record(RecordKind::Header, written, file);
}

void append(const CapturedFrame& frame, std::vector<std::byte>& file) {
  append_record(RecordKind::Frame, frame.input, file);
  append_heard(frame.before, file);
  if (frame.asked) {
    std::vector<std::byte> message;
    encode(ClientMessage(RequestMessage{.request = frame.asked->request}), message);
    append_record(RecordKind::Asked, DatedBytes{frame.asked->sent, message}, file);
  }
  append_heard(frame.after, file);
  append_record(RecordKind::Shown, ShownRecord{frame.shown}, file);
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

Decoded<CapturedMessage> decode_heard(std::span<const std::byte> bytes) {
  const Decoded<DatedBytes> dated = codec::read<DatedBytes>(ByteReader(bytes));
  if (!dated) return refuse(dated.error());
  if (const Decoded<ServerMessage> message = decode_server(dated->bytes); !message)
    return refuse(message.error());
  return CapturedMessage{dated->time, {dated->bytes.begin(), dated->bytes.end()}};
}

Decoded<CapturedRequest> decode_asked(std::span<const std::byte> bytes) {
  const Decoded<DatedBytes> dated = codec::read<DatedBytes>(ByteReader(bytes));
  if (!dated) return refuse(dated.error());
  Decoded<ClientMessage> message = decode_client(dated->bytes);
  if (!message) return refuse(message.error());
  return CapturedRequest{dated->time, std::move(std::get<RequestMessage>(*message).request)};
}

Decoded<PerEye<PictureHash>> decode_shown(std::span<const std::byte> bytes) {
  return codec::read<ShownRecord>(ByteReader(bytes)).map([](const ShownRecord& shown) {
    return shown.pictures;
  });
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
