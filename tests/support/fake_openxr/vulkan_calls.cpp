// XR_KHR_vulkan_enable2: instance and device are made by the Vulkan loader.
#include "tests/support/fake_openxr/runtime.h"

namespace farshade::fake_openxr {
namespace {

XrResult get_requirements(XrInstance, XrSystemId system, XrGraphicsRequirementsVulkanKHR* needs) {
  if (system != state().script.system) return XR_ERROR_SYSTEM_INVALID;
  state().asked.insert(system);
  needs->minApiVersionSupported = state().script.least_vulkan;
  needs->maxApiVersionSupported = XR_MAKE_VERSION(1, 3, 0);
  return XR_SUCCESS;
}

XrResult create_vulkan_instance(XrInstance, const XrVulkanInstanceCreateInfoKHR* info, VkInstance* made,
                                VkResult* result) {
  if (info->systemId != state().script.system) return XR_ERROR_SYSTEM_INVALID;
  *result = vkCreateInstance(info->vulkanCreateInfo, info->vulkanAllocator, made);
  return XR_SUCCESS;
}

XrResult get_device(XrInstance, const XrVulkanGraphicsDeviceGetInfoKHR* info, VkPhysicalDevice* device) {
  if (info->systemId != state().script.system) return XR_ERROR_SYSTEM_INVALID;
  std::uint32_t count = 1;
  const VkResult result = vkEnumeratePhysicalDevices(info->vulkanInstance, &count, device);
  if (result < 0 || count == 0) return XR_ERROR_RUNTIME_FAILURE;
  if (state().script.other_gpu) *device = reinterpret_cast<VkPhysicalDevice>(std::uintptr_t{1});
  return XR_SUCCESS;
}

XrResult create_vulkan_device(XrInstance, const XrVulkanDeviceCreateInfoKHR* info, VkDevice* made,
                              VkResult* result) {
  if (info->systemId != state().script.system) return XR_ERROR_SYSTEM_INVALID;
  *result = vkCreateDevice(info->vulkanPhysicalDevice, info->vulkanCreateInfo, info->vulkanAllocator, made);
  return XR_SUCCESS;
}

}  // namespace

std::vector<Function> vulkan_calls() {
  constexpr const char* kVulkan = XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME;
  return {entry<"xrGetVulkanGraphicsRequirements2KHR", &get_requirements>(kVulkan),
          entry<"xrCreateVulkanInstanceKHR", &create_vulkan_instance>(kVulkan),
          entry<"xrGetVulkanGraphicsDevice2KHR", &get_device>(kVulkan),
          entry<"xrCreateVulkanDeviceKHR", &create_vulkan_device>(kVulkan)};
}

}  // namespace farshade::fake_openxr
