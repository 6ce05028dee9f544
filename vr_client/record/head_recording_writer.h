/// HeadRecordingWriter: the head of a session as a recording like those that sessions replay (stereo/trace).
#pragma once

#include "stereo/base/expected.h"
#include "stereo/head/writer.h"

namespace farshade {

class HeadRecordingWriter {
 public:
  /// The head between the eyes of `views`, which were shown at `display_time`. A time that is not after the
  /// last one is left out. Eye distance and fov of the last views are those of the recording: it has one
  /// headset.
  void add(Time display_time, const StereoView& views);

  [[nodiscard]] const HeadRecording& trace() const { return trace_; }

  /// EuRoC/ASL CSV in stage axes. Refuses fewer frames than a recording needs (OutOfRange).
  [[nodiscard]] Expected<void> write(const std::filesystem::path& path) const;

 private:
  HeadRecording trace_;
};

}  // namespace farshade
