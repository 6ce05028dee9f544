#include "stereo/gpu/loader.h"

#include <vulkan/vulkan_raii.hpp>

namespace farshade::gpu {

std::string loader_version() {
  const std::uint32_t version = vk::raii::Context().enumerateInstanceVersion();
  return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) +
         "." + std::to_string(VK_API_VERSION_PATCH(version));
}

}  // namespace farshade::gpu
