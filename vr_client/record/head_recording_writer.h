/// HeadRecordingWriter: records the head poses of a run as a head recording (stereo/head).
#pragma once

#include "stereo/base/expected.h"
#include "stereo/head/writer.h"

namespace farshade {

class HeadRecordingWriter {
 public:
  /// Adds the head pose between the eyes of `views`, which were shown at `display_time`. Skips a time that is
  /// not later than the last one. The recording has one eye distance and one fov per eye: those of the last
  /// views.
  void add(Time display_time, const StereoView& views);

  [[nodiscard]] const HeadRecording& recording() const { return recording_; }

  /// Writes an EuRoC/ASL CSV file in stage axes. OutOfRange if there are fewer samples than a recording
  /// needs.
  [[nodiscard]] Expected<void> write(const std::filesystem::path& path) const;

 private:
  HeadRecording recording_;
};

}  // namespace farshade
