/// CaptureReader: a session file, frame by frame. Holds one frame at a time; no length in the file sizes an
/// allocation before it was checked.
#pragma once

#include <filesystem>
#include <istream>
#include <memory>

#include "stereo/base/expected.h"
#include "vr_client/record/capture_file.h"

namespace farshade {

class CaptureReader {
 public:
  /// Refuses what is not there (Missing), may not be read (Unreadable), is no session file or another
  /// version's (Unsupported), or ends before its header does (Malformed).
  [[nodiscard]] static Expected<CaptureReader> open(const std::filesystem::path& path);
  /// The same from any bytes; `name` is what errors call them.
  [[nodiscard]] static Expected<CaptureReader> over(std::unique_ptr<std::istream> bytes, std::string name);

  [[nodiscard]] const CaptureHeader& header() const { return header_; }
  [[nodiscard]] const std::string& name() const { return name_; }

  /// The next frame; nothing at the end. A frame that the file's end cuts off is not there: its recorder was
  /// stopped. Anything else that is wrong is an error that names file and byte, after which nothing can be
  /// read.
  [[nodiscard]] Expected<std::optional<CapturedFrame>> next();

 private:
  struct Record {
    RecordKind kind;
    std::uint64_t at;  ///< of its head, in the file
  };

  CaptureReader(std::unique_ptr<std::istream> bytes, std::string name)
      : bytes_(std::move(bytes)), name_(std::move(name)) {}

  [[nodiscard]] Expected<void> begin();
  [[nodiscard]] bool read(std::size_t size);
  [[nodiscard]] Expected<std::optional<Record>> next_record();
  [[nodiscard]] Expected<void> take(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] Expected<void> take_frame(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] Expected<void> take_heard(const Record& record, CapturedFrame& frame) const;
  [[nodiscard]] tl::unexpected<Error> fail_at(std::uint64_t at, const std::string& what) const;
  [[nodiscard]] tl::unexpected<Error> refused(const Record& record, WireRefusal why) const;

  std::unique_ptr<std::istream> bytes_;
  std::string name_;
  CaptureHeader header_;
  std::vector<std::byte> body_;  ///< of the record at hand
  std::uint64_t at_ = 0;         ///< bytes read
  std::optional<Time> shown_at_;
};

/// Reads a file to its end. What CaptureReader::next says of it, or how many frames there are.
[[nodiscard]] Expected<std::uint32_t> count_frames(const std::filesystem::path& path);

}  // namespace farshade
