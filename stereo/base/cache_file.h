/// Cache file: content that a program can make again, kept between its runs. A digest follows the content, so
/// that a broken file is noticed before anything reads it.
#pragma once

#include <span>

#include "stereo/base/files.h"

namespace farshade {

/// A name of hexadecimal digits, for a file that belongs to `key`.
[[nodiscard]] std::string cache_name(std::span<const std::uint8_t> key);

/// The content of a file. Missing: there is none. Malformed: its digest is wrong. Otherwise as read_file.
[[nodiscard]] Expected<std::vector<std::byte>> read_cache_file(const std::filesystem::path& path,
                                                               std::uint64_t max_bytes);

/// Writes the file as write_file_atomically does. Makes its folder if necessary.
[[nodiscard]] Expected<void> write_cache_file(const std::filesystem::path& path,
                                              std::span<const std::byte> content);

}  // namespace farshade
