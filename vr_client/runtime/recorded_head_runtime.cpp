#include "vr_client/runtime/recorded_head_runtime.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#include "vr_client/runtime/headset.h"

namespace farshade {

std::uint32_t frame_count(const HeadRecording& recording, const HeadPlayback& playback) {
  const double length_s = std::max(0.0, seconds_of(recording.end() - recording.start() - playback.skip));
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  const double all = std::floor(length_s * playback.refresh_hz) + 1;
  return static_cast<std::uint32_t>(std::min(all, static_cast<double>(playback.frames.value_or(kMost))));
}

RecordedHeadRuntime::RecordedHeadRuntime(const HeadRecording& recording, const HeadPlayback& playback)
    : recording_(recording), playback_(playback), frame_count_(frame_count(recording, playback)) {}

Time RecordedHeadRuntime::display_time(std::uint32_t index) const {
  const auto offset_ns = std::llround(index * 1e9 / playback_.refresh_hz);
  return recording_.start() + playback_.skip + Duration(offset_ns);
}

std::optional<FrameTiming> RecordedHeadRuntime::wait_frame() {
  if (next_ >= frame_count_) return std::nullopt;
  if (playback_.pace == Pace::Real) {
    const Time now = clock_.now();
    if (!started_) started_ = now;  // so the first display time has not passed
    const auto due = [&](std::uint32_t index) { return *started_ + (display_time(index) - display_time(0)); };
    while (next_ + 1 < frame_count_ && due(next_) < now) ++next_, ++skipped_;
    std::this_thread::sleep_for(due(next_) - clock_.now());
  }
  return FrameTiming{display_time(next_++), Duration(std::llround(1e9 / playback_.refresh_hz))};
}

StereoView RecordedHeadRuntime::locate_views(Time display_time) {
  const Rigid<Stage, Head> stage_from_head =
      playback_.stage_from_recorded * head_at(recording_, display_time);
  return views_of(stage_from_head, {recording_.eye_distance_m, recording_.fov, playback_.eye_size});
}

}  // namespace farshade
