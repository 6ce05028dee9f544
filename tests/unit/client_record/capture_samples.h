/// Captures that the tests of vr_client/record share.
#pragma once

#include <algorithm>
#include <sstream>

#include "stereo/messages/bytes.h"
#include "tests/unit/messages/samples.h"
#include "vr_client/record/capture_reader.h"

namespace farshade::record_samples {

using wire_samples::Bytes;

inline constexpr Extent kEye{32, 24};

inline CaptureHeader header() {
  return {.scene = "room.glb",
          .scene_hash = wire_samples::counting_hash(),
          .lights = 3,
          .origin = MaskOrigin::Server,
          .limits = {.size = kEye, .traced_size = largest_traced(kEye), .depth_frames = 12},
          .detail_px = 0.25,
          .requests = 12,
          .refresh_hz = 72,
          .exposure = {-7},
          .policy = {.pace = Pace::Real, .round_trip = std::chrono::milliseconds(30)},
          .device = "a device"};
}

/// Frame `frame` of a display with a period of 14 ms.
inline CapturedFrameInput input(std::uint32_t frame) {
  CapturedFrameInput made{
      .timing = {Time(std::chrono::milliseconds(14) * frame), std::chrono::milliseconds(14)},
      .views = {},
      .settings = {}};
  for (View& view : made.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, kEye};
  made.views[1].stage_from_eye.translation.x = 0.064;
  return made;
}

inline CapturedMessage received(const ServerMessage& message, Time arrived = {}) {
  return {arrived, wire_samples::encoded(message)};
}

inline CapturedRequest sent_request(std::uint32_t frame) {
  const CapturedFrameInput shown = input(frame);
  return {shown.timing.display_time,
          {{FrameId{frame}, shown.timing.display_time, shown.timing.display_time, shown.views}}};
}

inline PerEye<PictureHash> pictures(unsigned first) {
  return {wire_samples::counting<16>(first), wire_samples::counting<16>(first + 100)};
}

/// A frame with every kind of record.
inline CapturedFrame frame(std::uint32_t number) {
  return {.input = input(number),
          .before = {received(wire_samples::welcome()), received(Probe{7})},
          .request = sent_request(number),
          .after = {received(FrameReport{.frame = {number}, .slices = 2}, Time(std::chrono::seconds(1)))},
          .pictures = pictures(number)};
}

inline Bytes file_of(const CaptureHeader& header, std::span<const CapturedFrame> frames) {
  Bytes bytes;
  append(header, bytes);
  for (const CapturedFrame& each : frames) append(each, bytes);
  append(CaptureEnd{static_cast<std::uint32_t>(frames.size())}, bytes);
  return bytes;
}

/// The file with the right checksums of its records, as far as their lengths lead: then a reader looks
/// further than the first changed byte.
inline Bytes with_right_checksums(Bytes file) {
  std::size_t at = kCapturePreamble_bytes;
  while (file.size() >= at + kRecordHead_bytes + kRecordChecksum_bytes) {
    std::uint32_t size = 0;
    ByteReader(std::span<const std::byte>(file).subspan(at + 1)).u32(size);
    if (file.size() - at - kRecordHead_bytes - kRecordChecksum_bytes < size) break;
    const std::size_t checked = kRecordHead_bytes + size;
    Bytes checksum;
    ByteWriter(checksum).u32(checksum_of(std::span<const std::byte>(file).subspan(at, checked)));
    std::ranges::copy(checksum, file.begin() + static_cast<std::ptrdiff_t>(at + checked));
    at += checked + kRecordChecksum_bytes;
  }
  return file;
}

/// A capture whose only frame has `message` as its request. A CaptureWriter writes only requests there.
inline Bytes file_with_request(const ClientMessage& message) {
  CapturedFrame quiet{.input = input(1), .before = {}, .request = {}, .after = {}, .pictures = pictures(1)};
  Bytes file = file_of(header(), std::vector{quiet});
  // The last records hold the hashes of both pictures and the number of frames.
  constexpr std::size_t kAround = kRecordHead_bytes + kRecordChecksum_bytes;
  const auto pictures_at = file.end() - static_cast<std::ptrdiff_t>(kAround + 2 * sizeof(PictureHash) +
                                                                    kAround + sizeof(std::uint32_t));
  const Bytes message_bytes = wire_samples::encoded(message);
  Bytes record;
  ByteWriter io(record);
  io.code(RecordKind::Request);
  io.u32(sizeof(std::int64_t) + message_bytes.size());
  io.ns(Time{});
  io.rest(message_bytes);
  io.u32(0);
  file.insert(pictures_at, record.begin(), record.end());
  return with_right_checksums(file);
}

inline Expected<CaptureReader> reader_of(std::span<const std::byte> bytes) {
  return CaptureReader::over(std::make_unique<std::istringstream>(
                                 std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())),
                             "a.capture");
}

}  // namespace farshade::record_samples
