#include "vr_client/record/capture_reader.h"

#include <fstream>

#include "stereo/wire/bytes.h"

namespace farshade {
namespace {

const char* name_of(RecordKind kind) {
  switch (kind) {
    case RecordKind::Header:
      return "header";
    case RecordKind::Frame:
      return "frame";
    case RecordKind::Heard:
      return "heard message";
    case RecordKind::Asked:
      return "asked request";
    case RecordKind::Shown:
      return "shown pictures";
  }
  return "unknown";
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
  if (!std::filesystem::exists(status)) return fail(Fault::Missing, "no session file at " + path.string());
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
  const bool whole = read(kSessionPreamble_bytes);
  ByteReader io(body_);
  if (!whole || !io.u32(magic) || !io.u16(version) || !io.u16(protocol) || magic != kSessionMagic)
    return fail(Fault::Unsupported, name_ + " is no session file");
  if (version != kSessionVersion || protocol != kProtocolVersion)
    return fail(Fault::Unsupported, name_ + " is a session file of version " + std::to_string(version) + "." +
                                        std::to_string(protocol) + "; this program reads " +
                                        std::to_string(kSessionVersion) + "." +
                                        std::to_string(kProtocolVersion));
  const Expected<std::optional<Record>> record = next_record();
  if (!record) return tl::unexpected(record.error());
  if (!*record) return fail_at(at_, "ends before its header does");
  if ((*record)->kind != RecordKind::Header) return fail_at((*record)->at, "does not begin with a header");
  Decoded<CaptureHeader> header = decode_header(body_);
  if (!header) return refused(**record, header.error());
  header_ = std::move(*header);
  return {};
}

/// Into `body_`; false if the file ends before.
bool CaptureReader::read(std::size_t size) {
  body_.resize(size);
  bytes_->read(reinterpret_cast<char*>(body_.data()), static_cast<std::streamsize>(size));
  const auto got = static_cast<std::size_t>(bytes_->gcount());
  at_ += got;
  return got == size;
}

/// Leaves its fields in `body_`. Nothing where the file ends, in it or before it.
Expected<std::optional<CaptureReader::Record>> CaptureReader::next_record() {
  Record record{.kind = RecordKind::Header, .at = at_};
  const auto at_end = [&]() -> Expected<std::optional<Record>> {
    if (bytes_->bad())
      return fail(Fault::Unreadable, name_ + " cannot be read on from byte " + std::to_string(at_));
    return std::nullopt;
  };
  if (!read(kRecordHead_bytes)) return at_end();
  ByteReader io(body_);
  std::uint32_t size = 0;
  io.code(record.kind);
  io.u32(size);
  if (record.kind < RecordKind::Header || record.kind > RecordKind::Shown)
    return fail_at(record.at, "no kind of record");
  if (size > kMaxRecord_bytes) return fail_at(record.at, "a record of " + std::to_string(size) + " bytes");
  if (!read(size)) return at_end();
  return record;
}

Expected<void> CaptureReader::take_frame(const Record& record, CapturedFrame& frame) const {
  Decoded<CapturedFrameInput> input = decode_frame(body_, header_.limits.size);
  if (!input) return refused(record, input.error());
  if (shown_at_ && input->timing.display_time < *shown_at_) return fail_at(record.at, "time runs backwards");
  const bool wide = input->steering.wish.guard_band == GuardBandUse::Measured;
  if (header_.origin == MaskOrigin::Server && wide &&
      header_.limits.traced_size != largest_traced(header_.limits.size))
    return fail_at(record.at, "a guard band in a session without one");
  frame.input = std::move(*input);
  return {};
}

Expected<void> CaptureReader::take_heard(const Record& record, CapturedFrame& frame) const {
  Decoded<CapturedMessage> heard = decode_heard(body_);
  if (!heard) return refused(record, heard.error());
  const Decoded<ServerMessage> message = decode_server(heard->bytes);
  const auto* const welcome = std::get_if<Welcome>(&*message);
  if (welcome && (welcome->scene_hash != header_.scene_hash || welcome->light_count != header_.lights))
    return fail_at(record.at, "a welcome to another scene");
  (frame.asked ? frame.after : frame.before).push_back(std::move(*heard));
  return {};
}

/// Of a frame that has begun.
Expected<void> CaptureReader::take(const Record& record, CapturedFrame& frame) const {
  const bool of_link = record.kind == RecordKind::Heard || record.kind == RecordKind::Asked;
  if (of_link && header_.origin != MaskOrigin::Server)
    return fail_at(record.at, "a server's word in a session without a server");
  if (record.kind == RecordKind::Heard) return take_heard(record, frame);
  if (record.kind == RecordKind::Asked) {
    if (frame.asked) return fail_at(record.at, "a second request in one frame");
    Decoded<CapturedRequest> asked = decode_asked(body_);
    if (!asked) return refused(record, asked.error());
    frame.asked = std::move(*asked);
    return {};
  }
  if (record.kind != RecordKind::Shown)
    return fail_at(record.at,
                   std::string("a frame that is not shown before the next ") + name_of(record.kind));
  const Decoded<PerEye<PictureHash>> shown = decode_shown(body_);
  if (!shown) return refused(record, shown.error());
  frame.shown = *shown;
  return {};
}

Expected<std::optional<CapturedFrame>> CaptureReader::next() {
  Expected<std::optional<Record>> record = next_record();
  if (!record) return tl::unexpected(record.error());
  if (!*record) return std::nullopt;
  if ((*record)->kind != RecordKind::Frame)
    return fail_at((*record)->at, std::string(name_of((*record)->kind)) + " of no frame");
  CapturedFrame frame;
  if (auto taken = take_frame(**record, frame); !taken) return tl::unexpected(taken.error());
  while ((*record)->kind != RecordKind::Shown) {
    record = next_record();
    if (!record) return tl::unexpected(record.error());
    if (!*record) return std::nullopt;
    if (auto taken = take(**record, frame); !taken) return tl::unexpected(taken.error());
  }
  shown_at_ = frame.input.timing.display_time;
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
