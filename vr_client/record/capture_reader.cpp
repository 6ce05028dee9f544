#include "vr_client/record/capture_reader.h"

#include <array>
#include <fstream>

#include "stereo/messages/bytes.h"
#include "stereo/sealing/layout.h"

namespace farshade {
namespace {

/// `kind` is one of RecordKind.
const char* name_of(RecordKind kind) {
  constexpr std::array names{"header", "frame", "received message", "request", "pictures", "end"};
  return names.at(static_cast<std::size_t>(kind) - static_cast<std::size_t>(RecordKind::Header));
}

}  // namespace

tl::unexpected<Error> CaptureReader::fail_at(std::uint64_t at, const std::string& what) const {
  return fail(Fault::Malformed, name_ + ": byte " + std::to_string(at) + ": " + what);
}

tl::unexpected<Error> CaptureReader::refused(const Record& record, WireRefusal why) const {
  return fail_at(record.at, std::string(name_of(record.kind)) + ": " + std::string(farshade::name_of(why)));
}

Expected<CaptureReader> CaptureReader::open(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return fail(Fault::Missing, "no capture file at " + path.string());
  auto file = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (std::filesystem::is_directory(status) || !*file)
    return fail(Fault::Unreadable, "cannot read " + path.string());
  return over(std::move(file), path.string());
}

Expected<CaptureReader> CaptureReader::over(std::unique_ptr<std::istream> bytes, std::string name) {
  CaptureReader reader(std::move(bytes), std::move(name));
  if (auto begun = reader.begin(); !begun) return tl::unexpected(begun.error());
  return reader;
}

Expected<void> CaptureReader::begin() {
  std::uint32_t magic = 0;
  std::uint16_t version = 0, protocol = 0;
  record_.clear();
  const bool whole = read(kCapturePreamble_bytes, record_);
  ByteReader io(record_);
  if (!whole || !io.u32(magic) || !io.u16(version) || !io.u16(protocol) || magic != kCaptureMagic)
    return fail(Fault::Unsupported, name_ + " is not a capture file");
  if (version != kCaptureVersion || !is_spoken(protocol) || layout_hash(protocol) != kLayoutHash)
    return fail(Fault::Unsupported, name_ + " is a capture file of version " + std::to_string(version) + "." +
                                        std::to_string(protocol) + "; this program reads version " +
                                        std::to_string(kCaptureVersion) + "." +
                                        std::to_string(kProtocolVersion));
  const Expected<std::optional<Record>> record = next_record();
  if (!record) return tl::unexpected(record.error());
  if (!*record) return fail_at(at_, "the file ends inside its header");
  if ((*record)->kind != RecordKind::Header)
    return fail_at((*record)->at, "the first record is not a header");
  Decoded<CaptureHeader> header = decode_header(body_);
  if (!header) return refused(**record, header.error());
  header_ = std::move(*header);
  return {};
}

/// Appends to `into`. False if the file ends first.
bool CaptureReader::read(std::size_t size, std::vector<std::byte>& into) {
  const std::size_t before = into.size();
  into.resize(before + size);
  bytes_->read(reinterpret_cast<char*>(into.data() + before), static_cast<std::streamsize>(size));
  const auto got = static_cast<std::size_t>(bytes_->gcount());
  at_ += got;
  return got == size;
}

/// Leaves the record's fields in `body_`. Returns nothing if the file ends before or inside the record.
Expected<std::optional<CaptureReader::Record>> CaptureReader::next_record() {
  Record record{.kind = RecordKind::Header, .at = at_};
  const auto at_end = [&]() -> Expected<std::optional<Record>> {
    if (bytes_->bad())
      return fail(Fault::Unreadable, name_ + " cannot be read from byte " + std::to_string(at_));
    return std::nullopt;
  };
  record_.clear();
  if (!read(kRecordHead_bytes, record_)) return at_end();
  ByteReader io(record_);
  std::uint32_t size = 0;
  io.code(record.kind);
  io.u32(size);
  if (size > kMaxRecord_bytes) return fail_at(record.at, "a record of " + std::to_string(size) + " bytes");
  if (!read(size + kRecordChecksum_bytes, record_)) return at_end();
  const auto checked = std::span<const std::byte>(record_).first(kRecordHead_bytes + size);
  std::uint32_t checksum = 0;
  ByteReader(std::span<const std::byte>(record_).last(kRecordChecksum_bytes)).u32(checksum);
  if (checksum != checksum_of(checked))
    return fail_at(record.at, "the record is damaged: its checksum is wrong");
  if (record.kind < RecordKind::Header || record.kind > RecordKind::End)
    return fail_at(record.at, "unknown kind of record");
  body_ = checked.subspan(kRecordHead_bytes);
  return record;
}

Expected<void> CaptureReader::take_frame(const Record& record, CapturedFrame& frame) const {
  Decoded<CapturedFrameInput> input = decode_frame(body_, header_.limits.size);
  if (!input) return refused(record, input.error());
  if (last_display_time_ && input->timing.display_time < *last_display_time_)
    return fail_at(record.at, "the display time runs backwards");
  const bool wide = input->settings.request.guard_band == GuardBandUse::Measured;
  if (header_.origin == MaskOrigin::Server && wide &&
      header_.limits.traced_size != largest_traced(header_.limits.size))
    return fail_at(record.at, "a guard band, though the header's traced size has no room for one");
  frame.input = std::move(*input);
  return {};
}

Expected<void> CaptureReader::take_received(const Record& record, CapturedFrame& frame) const {
  Decoded<CapturedMessage> received = decode_received(body_);
  if (!received) return refused(record, received.error());
  const Decoded<ServerMessage> message = decode_server(received->bytes);
  const auto* const welcome = std::get_if<Welcome>(&*message);
  if (welcome && (welcome->scene_hash != header_.scene_hash || welcome->light_count != header_.lights))
    return fail_at(record.at, "a welcome for another scene");
  (frame.request ? frame.after : frame.before).push_back(std::move(*received));
  return {};
}

/// Adds a record to a frame that has begun.
Expected<void> CaptureReader::take(const Record& record, CapturedFrame& frame) const {
  const bool from_link = record.kind == RecordKind::Received || record.kind == RecordKind::Request;
  if (from_link && header_.origin != MaskOrigin::Server)
    return fail_at(record.at, "a message in a capture without a server");
  if (record.kind == RecordKind::Received) return take_received(record, frame);
  if (record.kind == RecordKind::Request) {
    if (frame.request) return fail_at(record.at, "a second request in one frame");
    Decoded<CapturedRequest> request = decode_request(body_);
    if (!request) return refused(record, request.error());
    frame.request = std::move(*request);
    return {};
  }
  if (record.kind != RecordKind::Pictures)
    return fail_at(record.at,
                   std::string("the frame has no pictures before the next ") + name_of(record.kind));
  const Decoded<PerEye<PictureHash>> pictures = decode_pictures(body_);
  if (!pictures) return refused(record, pictures.error());
  frame.pictures = *pictures;
  return {};
}

std::optional<CapturedFrame> CaptureReader::end_early() {
  cut_off_ = name_ + " is cut off after " + std::to_string(frames_) + " frames, at byte " +
             std::to_string(at_) + ": it has no end record, so later frames may be missing";
  return std::nullopt;
}

Expected<void> CaptureReader::end(const Record& record) {
  const Decoded<CaptureEnd> ended = decode_end(body_);
  if (!ended) return refused(record, ended.error());
  if (ended->frames != frames_)
    return fail_at(record.at, "the file has " + std::to_string(frames_) + " frames instead of " +
                                  std::to_string(ended->frames));
  if (bytes_->peek() != std::istream::traits_type::eof()) return fail_at(at_, "bytes after the end record");
  return {};
}

Expected<std::optional<CapturedFrame>> CaptureReader::next() {
  Expected<std::optional<Record>> record = next_record();
  if (!record) return tl::unexpected(record.error());
  if (!*record) return end_early();
  if ((*record)->kind == RecordKind::End)
    return end(**record).map([] { return std::optional<CapturedFrame>(); });
  if ((*record)->kind != RecordKind::Frame)
    return fail_at((*record)->at, std::string(name_of((*record)->kind)) + " outside of a frame");
  CapturedFrame frame;
  if (auto taken = take_frame(**record, frame); !taken) return tl::unexpected(taken.error());
  while ((*record)->kind != RecordKind::Pictures) {
    record = next_record();
    if (!record) return tl::unexpected(record.error());
    if (!*record) return end_early();
    if (auto taken = take(**record, frame); !taken) return tl::unexpected(taken.error());
  }
  last_display_time_ = frame.input.timing.display_time;
  ++frames_;
  return frame;
}

Expected<std::uint32_t> count_frames(const std::filesystem::path& path) {
  Expected<CaptureReader> reader = CaptureReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  for (std::uint32_t frames = 0;; ++frames) {
    const Expected<std::optional<CapturedFrame>> frame = reader->next();
    if (!frame) return tl::unexpected(frame.error());
    if (!*frame) return frames;
  }
}

}  // namespace farshade
