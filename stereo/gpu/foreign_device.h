/// ForeignDevice: a Vulkan device that somebody else has made, in Vulkan's own types.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>

namespace farshade::gpu {

/// Vulkan 1.3, with the features dynamicRendering, synchronization2, maintenance4 and shaderOutputLayer
/// enabled. Everything came from the Vulkan loader that this program is linked with.
struct ForeignDevice {
  VkInstance instance;
  VkPhysicalDevice physical;
  VkDevice logical;
  VkQueue queue;  ///< of `queue_family`, which draws and computes
  std::uint32_t queue_family;
};

}  // namespace farshade::gpu
