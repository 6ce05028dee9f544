/// Takes: what a viewer keeps of a preview: screenshots, the head, every frame, the whole session. Each goes
/// to a new file or folder of the output folder, and none is ever written over. A failure to write ends that
/// take and is said; the preview goes on.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "vr_client/record/capture_writer.h"
#include "vr_client/record/head_recording_writer.h"

namespace farshade {

class Recordings {
 public:
  /// `clock` is the link's.
  Recordings(std::filesystem::path out, const Clock& clock) : out_(std::move(out)), clock_(clock) {}

  /// The last thing worth saying: a file that was written, a failure.
  [[nodiscard]] const std::string& note() const { return note_; }

  /// Each eye's picture, and the window's if it has one now: `screenshot_NNNN_{left,right,window}.png`.
  void take_screenshot(const PerEye<Image<Rgb8>>& eyes, const Image<Rgb8>& window);

  /// `head_NNNN.csv`, written when it ends.
  void toggle_head();
  [[nodiscard]] bool records_head() const { return head_.has_value(); }

  /// `frames_NNNN/frame_NNNNN.png`: both eyes side by side, overlays included.
  void toggle_frames();
  [[nodiscard]] bool records_frames() const { return frames_.has_value(); }

  /// `session_NNNN.farshade`. First what the link shall tell, before it meets a server (if there is to be
  /// one); then the file, before the first frame. The link may tell as long as this lives.
  [[nodiscard]] LinkListener listen();
  /// An empty `path` is a new one of the output folder's; a file at any other is replaced.
  void begin_session(const std::filesystem::path& path, const CaptureHeader& header);
  void end_session();
  [[nodiscard]] bool records_session() const { return session_ != nullptr; }

  /// A frame was shown; `shown` are its eyes as drawn. Only if some take records pictures: `on_show`.
  void watch(const FrameView& view, const PerEye<Image<Rgb8>>* shown, const PerEye<Image<Rgb8>>* on_show);

  /// Ends all takes. The first failure of any.
  [[nodiscard]] Expected<void> finish();

 private:
  struct Frames {
    std::filesystem::path folder;
    std::uint32_t written = 0;
  };
  [[nodiscard]] std::filesystem::path unused(const char* what, const char* extension) const;
  void say(const Expected<void>& done, const std::string& otherwise);

  std::filesystem::path out_;
  const Clock& clock_;
  std::optional<HeadRecordingWriter> head_;
  std::optional<Frames> frames_;
  std::unique_ptr<CaptureWriter> session_;
  std::filesystem::path session_path_;
  std::string note_;
  std::optional<Error> failed_;
};

}  // namespace farshade
