/// Session files that the tests of record/ share.
#pragma once

#include <sstream>

#include "tests/unit/wire/samples.h"
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
          .requests = 12,
          .refresh_hz = 72,
          .policy = {.pace = Pace::Real, .round_trip = std::chrono::milliseconds(30)},
          .device = "a device"};
}

/// The display's frame of this number, 14 ms a frame.
inline CapturedFrameInput input(std::uint32_t frame) {
  CapturedFrameInput made{
      .timing = {Time(std::chrono::milliseconds(14) * frame), std::chrono::milliseconds(14)},
      .views = {},
      .steering = {}};
  for (View& view : made.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, kEye};
  made.views[1].stage_from_eye.translation.x = 0.064;
  return made;
}

inline CapturedMessage heard(const ServerMessage& message, Time arrived = {}) {
  return {arrived, wire_samples::encoded(message)};
}

inline CapturedRequest asked(std::uint32_t frame) {
  const CapturedFrameInput shown = input(frame);
  return {shown.timing.display_time,
          {FrameId{frame}, shown.timing.display_time, shown.timing.display_time, shown.views}};
}

inline PerEye<PictureHash> pictures(unsigned first) {
  return {wire_samples::counting<16>(first), wire_samples::counting<16>(first + 100)};
}

/// A frame with everything in it.
inline CapturedFrame frame(std::uint32_t number) {
  return {.input = input(number),
          .before = {heard(wire_samples::welcome()), heard(Probe{7})},
          .asked = asked(number),
          .after = {heard(FrameReport{.frame = {number}, .slices = 2}, Time(std::chrono::seconds(1)))},
          .shown = pictures(number)};
}

inline Bytes file_of(const CaptureHeader& header, std::span<const CapturedFrame> frames) {
  Bytes bytes;
  append(header, bytes);
  for (const CapturedFrame& each : frames) append(each, bytes);
  return bytes;
}

inline Expected<CaptureReader> reader_of(std::span<const std::byte> bytes) {
  return CaptureReader::over(std::make_unique<std::istringstream>(
                                 std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())),
                             "a.session");
}

}  // namespace farshade::record_samples
