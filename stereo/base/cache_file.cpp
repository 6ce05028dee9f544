#include "stereo/base/cache_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>

#include "stereo/base/digest.h"

namespace farshade {

std::string cache_name(std::span<const std::uint8_t> key) {
  return fmt::format("{:02x}", fmt::join(key, ""));
}

Expected<std::vector<std::byte>> read_cache_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  Expected<std::vector<std::byte>> file = read_file(path, max_bytes);
  if (!file) return file;
  if (file->size() < sizeof(Digest)) return fail(Fault::Malformed, "it is too short");
  const std::size_t size = file->size() - sizeof(Digest);
  const Digest digest = digest_of(std::span(*file).first(size));
  if (std::memcmp(&(*file)[size], digest.data(), digest.size()) != 0)
    return fail(Fault::Malformed, "its digest is wrong");
  file->resize(size);
  return file;
}

Expected<void> write_cache_file(const std::filesystem::path& path, std::span<const std::byte> content) {
  std::vector<std::byte> file(content.begin(), content.end());
  const Digest digest = digest_of(content);
  file.resize(content.size() + digest.size());
  std::memcpy(&file[content.size()], digest.data(), digest.size());
  std::error_code error;  // if the folder cannot be made, the file cannot be written
  std::filesystem::create_directories(path.parent_path(), error);
  return write_file_atomically(path, file);
}

}  // namespace farshade
