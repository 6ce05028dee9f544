/// CaptureWriter: writes a capture file during a run. Its listener must be given to the link before the link
/// connects to the server. The writer appends each frame as soon as the frame was shown: a program that is
/// killed leaves all complete frames, and no end record.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include "stereo/link/network_link.h"
#include "vr_client/record/capture_file.h"

namespace farshade {

class CaptureWriter {
 public:
  /// `clock` must be the clock of the link.
  explicit CaptureWriter(const Clock& clock) : clock_(clock) {}

  /// The functions that the link calls for each message and request. They refer to this writer, which must
  /// not move.
  [[nodiscard]] LinkListener listener();

  ~CaptureWriter() { static_cast<void>(finish()); }
  CaptureWriter(const CaptureWriter&) = delete;
  CaptureWriter& operator=(const CaptureWriter&) = delete;

  /// Unavailable if a file exists at `path`. An empty path is no file.
  [[nodiscard]] static Expected<void> may_create(const std::filesystem::path& path);

  /// Creates the file. Call it before the first frame. Unavailable if the file exists.
  [[nodiscard]] Expected<void> open(const std::filesystem::path& path, const CaptureHeader& header);

  /// Appends a frame that was shown as these pictures. A failure to write ends the capture, not the run.
  void watch(const FrameView& view, const PerEye<Image<Rgb8>>& shown);

  /// Writes the end record and closes the file. Returns failed(). The destructor does the same.
  Expected<void> finish();

  /// Frames are added no more: it is finished, or has failed.
  [[nodiscard]] bool has_ended() const { return file_ == nullptr; }
  /// Why the capture ended early; the sentence names file and frame.
  [[nodiscard]] const std::optional<Error>& failed() const { return failed_; }
  [[nodiscard]] std::uint32_t frames() const { return frames_; }  ///< in the file
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }    ///< of the file

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[nodiscard]] bool write();

  const Clock& clock_;
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
  CapturedFrame frame_;  ///< messages and request since the last frame was shown
  std::vector<std::byte> pending_;
  std::uint32_t frames_ = 0;
  std::uint64_t bytes_ = 0;
  std::optional<Error> failed_;
};

}  // namespace farshade
