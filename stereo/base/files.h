/// Whole files as byte strings. A write is atomic: readers see the old file or the whole new one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "stereo/base/descriptor.h"
#include "stereo/base/expected.h"

namespace farshade {

/// Returns all bytes of a regular file. Refuses other kinds of files, and files of more than `max_bytes`
/// before it reads them.
[[nodiscard]] Expected<std::vector<std::byte>> read_file(const std::filesystem::path& path,
                                                         std::uint64_t max_bytes);

/// When the file was changed last, in nanoseconds since 1970; 0 if that cannot be found out.
[[nodiscard]] std::int64_t changed_at(const std::filesystem::path& path);

/// Writes a temporary file beside `path` and renames it to `path`. After a failure `path` is unchanged and
/// the temporary file is gone. The folder must exist.
[[nodiscard]] Expected<void> write_file_atomically(const std::filesystem::path& path,
                                                   std::span<const std::byte> bytes);
[[nodiscard]] Expected<void> write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// Makes a folder if it does not exist. Refuses (Unreadable) a folder to which no file can be written. No
/// file in it changes.
[[nodiscard]] Expected<void> make_folder(const std::filesystem::path& folder);

/// Keeps other holders out of a folder's lock, in this and in other programs, for as long as it lives.
class FolderLock {
 public:
  /// Waits until nobody has it. `folder` may be empty: the current one.
  [[nodiscard]] static Expected<FolderLock> of(const std::filesystem::path& folder);

 private:
  explicit FolderLock(Descriptor folder) : folder_(std::move(folder)) {}
  Descriptor folder_;
};

// ---- files with secrets

/// Whether a file with this mode that belongs to `owner` is secret enough for the user `reader`: nobody but
/// its owner may read or write it, or it is root's, who lets a group read it that the reader is in
/// (Kubernetes gives secrets in no other way).
[[nodiscard]] bool is_private(unsigned mode, unsigned owner, unsigned reader);

/// As read_file. Refuses (Unreadable) a file that is not private (is_private), and a file that belongs to
/// neither this user nor root. The error tells how to fix it.
[[nodiscard]] Expected<std::vector<std::byte>> read_private_file(const std::filesystem::path& path,
                                                                 std::uint64_t max_bytes);

enum class IfThere { Replace, Refuse };

/// As write_file_atomically, with mode 0600, and on the disk when the call returns. With IfThere::Refuse an
/// existing file is an error (Unavailable) and stays unchanged.
[[nodiscard]] Expected<void> write_private_file(const std::filesystem::path& path, std::string_view text,
                                                IfThere if_there);

}  // namespace farshade
