/// RecordedHeadRuntime: a recorded head played back at a display's refresh rate. In virtual time every
/// display time gets its frame; in real time frames that come too late are skipped and counted.
#pragma once

#include <cstdint>

#include "stereo/head/head_recording.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

struct HeadPlayback {
  Rigid<Stage, Recorded> stage_from_recorded;
  Extent eye_size;
  double refresh_hz = 72;
  Duration skip{};                      ///< of the recording's beginning
  std::optional<std::uint32_t> frames;  ///< display times to show; until the recording's end if not said
  Pace pace = Pace::Virtual;
};

class RecordedHeadRuntime final : public Runtime {
 public:
  /// Keeps a reference to `trace`.
  RecordedHeadRuntime(const HeadRecording& trace, const HeadPlayback& playback);

  [[nodiscard]] std::optional<FrameTiming> wait_frame() override;
  [[nodiscard]] StereoView locate_views(Time display_time) const override;
  void end_frame(Time display_time) override;

  /// Display times that the playback has in all.
  [[nodiscard]] std::uint32_t frame_count() const { return frame_count_; }
  /// Real time only: display times that passed before their frame could begin.
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }

 private:
  [[nodiscard]] Time display_time(std::uint32_t index) const;

  const HeadRecording& trace_;
  HeadPlayback playback_;
  std::uint32_t frame_count_;
  std::uint32_t next_ = 0;
  std::uint64_t skipped_ = 0;
  SteadyClock clock_;
  std::optional<Time> started_;  ///< real time at which display time 0 fell
};

}  // namespace farshade
