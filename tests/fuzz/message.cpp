// Messages: arbitrary bytes as the content of an opened datagram. They are refused, or they decode to a
// message within the ranges that tracer and assembler rely on, and encoding it gives the same bytes. The
// first byte selects the side that decodes.
#include "stereo/messages/messages.h"

#include <algorithm>
#include <cmath>

#include "stereo/frame/tiles.h"
#include "tests/fuzz/target.h"

using namespace farshade;

namespace {

void check_span(std::int64_t ns, std::int64_t least) {
  constexpr std::int64_t most = std::int64_t{1} << 61;
  check(ns >= least && ns <= most, "sums and differences of times do not overflow");
}

void check_place(double x, double y, double z) {
  for (const double c : {x, y, z}) check(std::isfinite(c) && std::abs(c) <= 1e9, "a place is on the stage");
}

void check_ranges(const View& view) {
  const auto& q = view.stage_from_eye.rotation;
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  check(std::abs(length - 1) <= 1.001e-3, "rotations are unit");
  const auto& t = view.stage_from_eye.translation;
  check_place(t.x, t.y, t.z);
  const EyeFov& fov = view.fov;
  for (const double angle : {fov.left_rad, fov.right_rad, fov.up_rad, fov.down_rad})
    check(std::isfinite(angle) && std::abs(angle) < 1.5708, "an angle is below 90 degrees");
  check(fov.left_rad < fov.right_rad && fov.down_rad < fov.up_rad, "angles are in order");
  for (const std::uint32_t side : {view.size.width, view.size.height})
    check(side >= 1 && side <= kMaxViewSide_px, "a view is within the size limit");
}

void check_ranges(const RequestMessage& message) {
  const FrameRequest& request = message.request;
  for (const View& view : request.views) check_ranges(view);
  for (const Time time : {request.display_time, request.scene_time, message.arrivals.base})
    check_span(ns_of(time), -(std::int64_t{1} << 61));
  check(request.lights.lights.size() <= RequestMessage::kMostLightChanges,
        "light changes within their limit");
  for (const LightChange& change : request.lights.lights) {
    check(change.light < kMaxLights, "a light index within its limit");
    if (!change.pose) continue;
    const auto &p = change.pose->position.v, &d = change.pose->direction.v;
    check_place(p.x, p.y, p.z);
    check(std::abs(std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) - 1) <= 1.001e-3, "directions are unit");
  }
  check(static_cast<std::uint8_t>(request.answer.kind) < kAnswers, "a known kind of answer");
  check(request.answer.bits_per_second <= kMostVideo_bits, "a bit rate within its limit");
  check_span(request.answer.interval.count(), 0);
  check(message.arrivals.count <= ArrivalReport::kMost, "an arrival report within its limit");
}

void check_ranges(const AskSlice& slice) {
  check(slice.size.width <= kMaxViewSide_px && slice.size.height <= kMaxViewSide_px,
        "a view is within the size limit");
  check(slice.lights <= kMaxLights, "lights within the limit of a mask");
  check(slice.tile_count >= 1 && slice.first_tile + slice.tile_count <= TileGrid{slice.size}.count(),
        "tiles of the grid");
}
void check_ranges(const PlaneSlice& slice) {
  check(slice.kind <= PlaneKind::PositionZ && slice.word_bytes >= 1 && slice.word_bytes <= 4,
        "a plane within the mask");
  check(slice.size.width <= kMaxViewSide_px && slice.size.height <= kMaxViewSide_px,
        "a size within its limit");
  check(slice.tile_count >= 1 &&
            std::uint64_t{slice.first_tile} + slice.tile_count <= std::uint64_t{TileGrid{slice.size}.count()},
        "tiles in the grid");
}

void check_ranges(const VideoPart& part) {
  check(part.part < part.parts && part.parts <= kMostVideoParts, "a part of a picture");
  check(!part.bytes.empty() && part.bytes.size() <= kVideoPart_bytes, "a part has bytes");
}

void check_ranges(const Slice& slice) {
  check(slice.lights <= kMaxLights && slice.plane < MaskLayout{slice.lights}.planes(),
        "a plane within the mask");
  check(slice.size.width <= kMaxViewSide_px && slice.size.height <= kMaxViewSide_px,
        "a size within its limit");
  check(slice.tile_count >= 1 &&
            std::uint64_t{slice.first_tile} + slice.tile_count <= std::uint64_t{TileGrid{slice.size}.count()},
        "tiles in the grid");
}

void check_ranges(const FrameReport& report) {
  for (const Duration span :
       {report.update, report.primary, report.shadow, report.draw, report.pack, report.waited})
    check_span(span.count(), 0);
  check(is_valid(report.view_scale), "a valid scale");
}

void check_ranges(const Welcome& welcome) {
  check(welcome.light_count <= kMaxLights, "lights within the limit of a mask");
}
void check_ranges(const Refusal&) {}
void check_ranges(const Probe& probe) {
  check(probe.token != 0, "a token is not the default");
}

void check_ranges(const Leave&) {}
void check_ranges(const Goodbye& goodbye) {
  check(goodbye.reason >= EndReason::ServerEnds && goodbye.reason <= EndReason::Withdrawn, "a known reason");
}
void check_ranges(const PathProbe& probe) {
  check(std::ranges::all_of(probe.padding, [](std::byte byte) { return byte == std::byte{0}; }),
        "padding is zeros");
}

void check_any(const auto& message, std::span<const std::byte> bytes) {
  if (!message) return;
  std::visit([](const auto& m) { check_ranges(m); }, *message);
  std::vector<std::byte> again;
  encode(*message, again);
  check(std::ranges::equal(again, bytes), "encoding gives the same bytes");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices choices(data, size);
  const bool from_client = choices.up_to(1) == 0;
  const std::span<const std::byte> bytes = choices.rest();
  if (from_client)
    check_any(decode_client(bytes), bytes);
  else
    check_any(decode_server(bytes), bytes);
  return 0;
}
