/// Field lists and range checks of times, views and light changes, for messages and for capture files. Only
/// the .cpp files that define messages and records include it.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>

#include "stereo/base/clock.h"
#include "stereo/frame/exposure.h"
#include "stereo/frame/eye_mask.h"
#include "stereo/frame/light_changes.h"
#include "stereo/frame/view.h"
#include "stereo/messages/message_codec.h"

namespace farshade {

inline constexpr std::int64_t kMaxTime_ns = std::int64_t{1}
                                            << 61;  // 73 years: sums and differences do not overflow
inline constexpr double kMaxCoordinate_m = 1e9;
inline constexpr double kMaxOffUnit = 1e-3;

// ---- field lists: `io` is a ByteWriter and the value const, or a ByteReader. They return false if the bytes
// end early.

bool fields(auto& io, codec::Either<Extent> auto& size) {
  return io.u16(size.width) && io.u16(size.height);
}

/// All fields of a view except its size.
bool look_fields(auto& io, codec::Either<View> auto& view) {
  auto& q = view.stage_from_eye.rotation;
  auto& t = view.stage_from_eye.translation;
  auto& fov = view.fov;
  return io.f64(q.w) && io.f64(q.x) && io.f64(q.y) && io.f64(q.z) &&  //
         io.f64(t.x) && io.f64(t.y) && io.f64(t.z) &&                 //
         io.f64(fov.left_rad) && io.f64(fov.right_rad) && io.f64(fov.up_rad) && io.f64(fov.down_rad);
}
bool fields(auto& io, codec::Either<View> auto& view) {
  return look_fields(io, view) && fields(io, view.size);
}

bool fields(auto& io, codec::Either<LightPose> auto& pose) {
  auto& p = pose.position.v;
  auto& d = pose.direction.v;
  return io.f64(p.x) && io.f64(p.y) && io.f64(p.z) && io.f64(d.x) && io.f64(d.y) && io.f64(d.z);
}

/// Quarter stops above the least.
inline bool fields(ByteWriter& io, const Exposure& exposure) {
  return io.u16(exposure.quarter_stops + Exposure::kMostQuarterStops);
}
bool fields(Reader auto& io, Exposure& exposure) {
  if (!io.u16(exposure.quarter_stops)) return false;
  exposure.quarter_stops -= Exposure::kMostQuarterStops;
  return true;
}

/// Bit 0: on; bit 1: a pose follows.
inline bool fields(ByteWriter& io, const LightChange& change) {
  const unsigned flags = (change.on ? 1u : 0u) | (change.pose ? 2u : 0u);
  return io.u16(change.light) && io.u32(change.revision.value) && io.u8(flags) &&
         (!change.pose || fields(io, *change.pose));
}
bool fields(Reader auto& io, LightChange& change) {
  std::uint8_t flags = 0;
  if (!io.u16(change.light) || !io.u32(change.revision.value) || !io.u8(flags)) return false;
  if (flags > 3) change.light = kMaxLights;  // unknown flags: the range check refuses the change
  change.on = (flags & 1u) != 0;
  return (flags & 2u) == 0 || fields(io, change.pose.emplace());
}

// ---- ranges

inline bool in_range(Time time) {
  return ns_of(time) >= -kMaxTime_ns && ns_of(time) <= kMaxTime_ns;
}
inline bool in_range(Duration span) {
  return span.count() >= 0 && span.count() <= kMaxTime_ns;
}
inline bool in_range(const glm::dvec3& place) {
  return std::abs(place.x) <= kMaxCoordinate_m && std::abs(place.y) <= kMaxCoordinate_m &&
         std::abs(place.z) <= kMaxCoordinate_m;  // false for NaN
}
inline bool in_range(const Exposure& exposure) {
  return std::abs(exposure.quarter_stops) <= Exposure::kMostQuarterStops;
}
inline bool in_range(const View& view) {
  return is_valid(view) && in_range(view.stage_from_eye.translation);
}
inline bool in_range(const LightPose& pose) {
  return in_range(pose.position.v) && std::abs(glm::length(pose.direction.v) - 1) <= kMaxOffUnit;
}

/// Checks one change of a list in ascending order of revisions. `before` is the previous change's revision,
/// and no change is newer than `newest`.
inline codec::Verdict verdict_on(const LightChange& change, LightSetRevision before,
                                 LightSetRevision newest) {
  const bool in_order = is_newer(change.revision, before) && !is_newer(change.revision, newest);
  if (change.light >= kMaxLights || !in_order) return WireRefusal::Lights;
  return change.pose && !in_range(*change.pose) ? codec::Verdict(WireRefusal::ViewRange) : codec::kFine;
}

}  // namespace farshade
