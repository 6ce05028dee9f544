/// RecordedHeadRuntime: plays a head recording at the refresh rate of a display. With Pace::Virtual every
/// display time gets its frame. With Pace::Real it skips display times that have passed, and counts them.
#pragma once

#include <cstdint>

#include "stereo/head/head_recording.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

struct HeadPlayback {
  Rigid<Stage, Recorded> stage_from_recorded;
  Extent eye_size;
  double refresh_hz = 72;
  Duration skip{};                      ///< at the beginning of the recording
  std::optional<std::uint32_t> frames;  ///< number of frames; empty: until the end of the recording
  Pace pace = Pace::Virtual;
};

/// Number of display times of a whole playback. They do not depend on where the head is placed.
[[nodiscard]] std::uint32_t frame_count(const HeadRecording& recording, const HeadPlayback& playback);

class RecordedHeadRuntime final : public Runtime {
 public:
  /// Keeps a reference to `recording`.
  RecordedHeadRuntime(const HeadRecording& recording, const HeadPlayback& playback);

  [[nodiscard]] std::optional<FrameTiming> wait_frame() override;
  [[nodiscard]] StereoView locate_views(Time display_time) override;

  /// Number of display times that passed before their frame could begin (Pace::Real).
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }

 private:
  [[nodiscard]] Time display_time(std::uint32_t index) const;

  const HeadRecording& recording_;
  HeadPlayback playback_;
  std::uint32_t frame_count_;
  std::uint32_t next_ = 0;
  std::uint64_t skipped_ = 0;
  SteadyClock clock_;
  std::optional<Time> started_;  ///< machine time of the first display time
};

}  // namespace farshade
