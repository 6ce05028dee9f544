/// Files as whole byte strings. A write is atomic: readers see the old file or the whole new one, never a
/// part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade {

/// All bytes of a regular file. Refuses other kinds of file, and more than `max_bytes` before reading any.
[[nodiscard]] Expected<std::vector<std::byte>> read_file(const std::filesystem::path& path,
                                                         std::uint64_t max_bytes);

/// Writes beside `path` and renames over it. On failure `path` is as it was and nothing is left behind.
/// The folder must exist.
[[nodiscard]] Expected<void> write_file_atomically(const std::filesystem::path& path,
                                                   std::span<const std::byte> bytes);
[[nodiscard]] Expected<void> write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// Makes a folder where there is none. Refuses (Unreadable) one that no file can be written to.
[[nodiscard]] Expected<void> make_folder(const std::filesystem::path& folder);

// ---- files with secrets

/// As read_file. Refuses (Unreadable, with the cure) a file that group or others may read or write, and one
/// that belongs to neither this user nor root.
[[nodiscard]] Expected<std::vector<std::byte>> read_private_file(const std::filesystem::path& path,
                                                                 std::uint64_t max_bytes);

enum class IfThere { Replace, Refuse };

/// As write_file_atomically, of mode 0600. A file that is there and should not be replaced stays as it is:
/// Unavailable.
[[nodiscard]] Expected<void> write_private_file(const std::filesystem::path& path, std::string_view text,
                                                IfThere if_there);

}  // namespace farshade
