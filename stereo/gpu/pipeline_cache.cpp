#include "stereo/gpu/pipeline_cache.h"

#include <sodium.h>

#include <cstring>

#include "stereo/base/check.h"
#include "stereo/base/files.h"

namespace farshade::gpu {
namespace {

/// A driver must ignore data of another driver, but need not survive broken data. So a digest follows the
/// data.
using Digest = std::array<unsigned char, 32>;
constexpr std::uint64_t kMostBytes = 256 << 20;

Digest digest_of(std::span<const std::byte> bytes) {
  check(sodium_init() >= 0, "libsodium starts");
  Digest digest;
  crypto_generichash(digest.data(), digest.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                     bytes.size(), nullptr, 0);
  return digest;
}

/// The data of a file if its digest is right; else nothing.
std::span<const std::byte> data_of(std::span<const std::byte> file) {
  if (file.size() < sizeof(Digest)) return {};
  const auto data = file.first(file.size() - sizeof(Digest));
  const Digest digest = digest_of(data);
  return std::memcmp(file.last(digest.size()).data(), digest.data(), digest.size()) == 0
             ? data
             : std::span<const std::byte>();
}

}  // namespace

std::filesystem::path pipeline_file(const Device& device, const std::filesystem::path& folder) {
  std::string name;
  for (const std::uint8_t byte : device.physical.getProperties().pipelineCacheUUID) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    name += {kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return folder / (name + ".pipelines");
}

void load_pipelines(Device& device, const std::filesystem::path& folder) {
  const Expected<std::vector<std::byte>> file = read_file(pipeline_file(device, folder), kMostBytes);
  const std::span<const std::byte> data = file ? data_of(*file) : std::span<const std::byte>();
  device.pipelines =
      device.logical.createPipelineCache({.initialDataSize = data.size(), .pInitialData = data.data()});
}

Expected<void> save_pipelines(const Device& device, const std::filesystem::path& folder) {
  const std::vector<std::uint8_t> data = device.pipelines.getData();
  std::vector<std::byte> file(data.size() + sizeof(Digest));
  if (!data.empty()) std::memcpy(file.data(), data.data(), data.size());
  const Digest digest = digest_of(std::span(file).first(data.size()));
  std::memcpy(&file[data.size()], digest.data(), digest.size());
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  return write_file_atomically(pipeline_file(device, folder), file);
}

}  // namespace farshade::gpu
