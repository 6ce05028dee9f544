/// CaptureReader: reads a capture file frame by frame. It holds one frame at a time. It checks every length
/// from the file before it allocates memory for it.
#pragma once

#include <filesystem>
#include <istream>
#include <memory>

#include "stereo/base/expected.h"
#include "vr_client/record/capture_file.h"

namespace farshade {

class CaptureReader {
 public:
  /// Errors: Missing (no such file), Unreadable, Unsupported (not a capture file, or another version),
  /// Malformed (the file ends inside its header).
  [[nodiscard]] static Expected<CaptureReader> open(const std::filesystem::path& path);
  /// Reads from any stream. Errors call it `name`.
  [[nodiscard]] static Expected<CaptureReader> over(std::unique_ptr<std::istream> bytes, std::string name);

  [[nodiscard]] const CaptureHeader& header() const { return header_; }

  /// Returns the next frame, or nothing at the end of the file. An incomplete last frame also ends the file:
  /// its writer was killed. Any other fault is an error that names file and byte; no frame can be read after
  /// it.
  [[nodiscard]] Expected<std::optional<CapturedFrame>> next();

 private:
  struct Record {
    RecordKind kind;
    std::uint64_t at;  ///< byte at which the record begins
  };

  CaptureReader(std::unique_ptr<std::istream> bytes, std::string name)
      : bytes_(std::move(bytes)), name_(std::move(name)) {}

  [[nodiscard]] Expected<void> begin();
  [[nodiscard]] bool read(std::size_t size);
  [[nodiscard]] Expected<std::optional<Record>> next_record();
  [[nodiscard]] Expected<void> take(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] Expected<void> take_frame(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] Expected<void> take_received(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] tl::unexpected<Error> fail_at(std::uint64_t at, const std::string& what) const;
  [[nodiscard]] tl::unexpected<Error> refused(const Record& record, WireRefusal why) const;

  std::unique_ptr<std::istream> bytes_;
  std::string name_;
  CaptureHeader header_;
  std::vector<std::byte> body_;  ///< of the current record
  std::uint64_t at_ = 0;         ///< bytes read
  std::optional<Time> last_display_time_;
};

/// Reads a whole file and returns its number of frames. Errors are those of CaptureReader::next.
[[nodiscard]] Expected<std::uint32_t> count_frames(const std::filesystem::path& path);

}  // namespace farshade
