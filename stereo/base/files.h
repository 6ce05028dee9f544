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

}  // namespace farshade
