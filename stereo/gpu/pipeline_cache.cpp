#include "stereo/gpu/pipeline_cache.h"

#include "stereo/base/cache_file.h"

namespace farshade::gpu {

std::filesystem::path pipeline_file(const Device& device, const std::filesystem::path& folder) {
  const auto uuid = device.physical.getProperties().pipelineCacheUUID;
  return folder / (cache_name(uuid) + ".pipelines");
}

bool load_pipelines(Device& device, const std::filesystem::path& folder) {
  // A driver must ignore data of another driver, but need not survive broken data.
  constexpr std::uint64_t kMostBytes = 256 << 20;
  const auto file = read_cache_file(pipeline_file(device, folder), kMostBytes);
  const std::span<const std::byte> data =
      file ? std::span<const std::byte>(*file) : std::span<const std::byte>();
  device.pipelines =
      device.logical.createPipelineCache({.initialDataSize = data.size(), .pInitialData = data.data()});
  return file.has_value();
}

Expected<void> save_pipelines(const Device& device, const std::filesystem::path& folder) {
  const std::vector<std::uint8_t> data = device.pipelines.getData();
  return write_cache_file(pipeline_file(device, folder), std::as_bytes(std::span(data)));
}

}  // namespace farshade::gpu
