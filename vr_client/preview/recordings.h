/// Recordings: the files that the viewer of a preview writes: screenshots, head recordings, pictures of every
/// frame and captures. Each goes to a new file or folder in the output folder; only --record and --timeline
/// replace their files. A failure to write ends that recording and is reported; the preview continues.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "stereo/head/writer.h"
#include "vr_client/record/capture_writer.h"

namespace farshade {

/// Records the head poses of a run as a head recording (stereo/head).
class HeadRecordingWriter {
 public:
  /// Adds the head pose between the eyes of `views`, which were shown at `display_time`. Skips a time that is
  /// not later than the last one. The recording has one eye distance and one fov per eye: those of the last
  /// views.
  void add(Time display_time, const StereoView& views);

  /// Writes an EuRoC/ASL CSV file in stage axes. OutOfRange if there are fewer samples than a recording
  /// needs.
  [[nodiscard]] Expected<void> write(const std::filesystem::path& path) const;

 private:
  HeadRecording recording_;
};

class Recordings {
 public:
  /// `clock` must be the clock of the link.
  Recordings(std::filesystem::path out, const Clock& clock) : out_(std::move(out)), clock_(clock) {}

  /// The last message: a file that was written, or a failure.
  [[nodiscard]] const std::string& note() const { return note_; }

  /// Writes the pictures of the eyes and, unless it is empty, of the window:
  /// `screenshot_NNNN_{left,right,window}.png`.
  void take_screenshot(const PerEye<Image<Rgb8>>& eyes, const Image<Rgb8>& window);

  /// `head_NNNN.csv`, written when the recording ends.
  void toggle_head();
  [[nodiscard]] bool records_head() const { return head_.has_value(); }

  /// `frames_NNNN/frame_NNNNN.png`: both eyes side by side, overlays included.
  void toggle_frames();
  [[nodiscard]] bool records_frames() const { return frames_.has_value(); }

  /// `capture_NNNN.farshade`. Call listen() before the link connects to the server, and begin_capture()
  /// before the first frame. The returned listener is valid as long as this object lives.
  [[nodiscard]] LinkListener listen();
  /// An empty `path` selects a new file in the output folder. An existing file at another path is refused.
  void begin_capture(const std::filesystem::path& path, const CaptureHeader& header);
  void end_capture();
  /// Says in note() that this mode cannot be captured.
  void refuse_capture(std::string_view mode);
  [[nodiscard]] bool writes_capture() const { return capture_ != nullptr; }

  /// Adds a shown frame. `shown` are its pictures as drawn, needed for a capture; `displayed` are the
  /// displayed pictures, needed while frames are written.
  void watch(const FrameView& view, const PerEye<Image<Rgb8>>* shown, const PerEye<Image<Rgb8>>* displayed);

  /// Ends all recordings. Returns the first failure.
  [[nodiscard]] Expected<void> finish();

 private:
  struct Frames {
    std::filesystem::path folder;
    std::uint32_t written = 0;
  };
  [[nodiscard]] std::filesystem::path unused(const char* what, const char* extension) const;
  void report(const Expected<void>& done, const std::string& success);

  std::filesystem::path out_;
  const Clock& clock_;
  std::optional<HeadRecordingWriter> head_;
  std::optional<Frames> frames_;
  std::unique_ptr<CaptureWriter> capture_;
  std::filesystem::path capture_path_;
  std::string note_;
  std::optional<Error> failed_;
};

}  // namespace farshade
