/// CaptureWriter: writes a session file while the session runs. It hears what the link hears from before
/// the link meets a server, and each frame goes to the file when it was shown, so that a recorder that is
/// killed leaves all frames but the last.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include "vr_client/link/network_link.h"
#include "vr_client/record/capture_file.h"

namespace farshade {

class CaptureWriter {
 public:
  /// `clock` is the link's.
  explicit CaptureWriter(const Clock& clock) : clock_(clock) {}

  /// What a link shall tell, from before it meets a server on. Speaks to this recorder, which must stay where
  /// it is.
  [[nodiscard]] LinkListener listener();

  /// Begins the file, once it is known what the session stands on: before its first frame.
  [[nodiscard]] Expected<void> open(const std::filesystem::path& path, const CaptureHeader& header);

  /// A frame was shown as these pictures. A failure to write ends the recording, not the session.
  void watch(const FrameView& view, const PerEye<Image<Rgb8>>& shown);

  /// Why nothing more is recorded, naming file and frame.
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
  CapturedFrame frame_;  ///< what has been heard and asked since the last frame was shown
  std::vector<std::byte> pending_;
  std::uint32_t frames_ = 0;
  std::uint64_t bytes_ = 0;
  std::optional<Error> failed_;
};

}  // namespace farshade
