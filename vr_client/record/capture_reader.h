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

  /// Returns the next frame, or nothing at the end of the file, which may be cut off (cut_off). Any other
  /// fault is an error that names file and byte; no frame can be read after it.
  [[nodiscard]] Expected<std::optional<CapturedFrame>> next();

  /// Set once next() has met the end of a file that has no end record: its writer was killed, or a part of
  /// the file is missing. Says where.
  [[nodiscard]] const std::optional<std::string>& cut_off() const { return cut_off_; }

 private:
  struct Record {
    RecordKind kind;
    std::uint64_t at;  ///< byte at which the record begins
  };

  CaptureReader(std::unique_ptr<std::istream> bytes, std::string name)
      : bytes_(std::move(bytes)), name_(std::move(name)) {}

  [[nodiscard]] Expected<void> begin();
  [[nodiscard]] bool read(std::size_t size, std::vector<std::byte>& into);
  [[nodiscard]] Expected<std::optional<Record>> next_record();
  [[nodiscard]] Expected<void> end(const Record& record);
  [[nodiscard]] std::optional<CapturedFrame> end_early();
  [[nodiscard]] Expected<void> take(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] Expected<void> take_frame(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] Expected<void> take_received(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] tl::unexpected<Error> fail_at(std::uint64_t at, const std::string& what) const;
  [[nodiscard]] tl::unexpected<Error> refused(const Record& record, WireRefusal why) const;

  std::unique_ptr<std::istream> bytes_;
  std::string name_;
  CaptureHeader header_;
  std::vector<std::byte> record_;    ///< kind, length, fields and checksum of the current record
  std::span<const std::byte> body_;  ///< the fields in it
  std::uint64_t at_ = 0;             ///< bytes read
  std::uint32_t frames_ = 0;         ///< read
  std::optional<std::string> cut_off_;
  std::optional<Time> last_display_time_;
};

/// Reads a whole file and returns its number of frames. Errors are those of CaptureReader::next.
[[nodiscard]] Expected<std::uint32_t> count_frames(const std::filesystem::path& path);

}  // namespace farshade
