#include "vr_client/openxr/instance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace farshade::openxr {
namespace {

constexpr const char* kVulkan = XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME;
constexpr const char* kDepthLayers = XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME;

Expected<std::vector<std::string>> offered_extensions() {
  std::uint32_t count = 0;
  if (auto done = succeeded(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr),
                            "xrEnumerateInstanceExtensionProperties");
      !done)
    return tl::unexpected(done.error());
  std::vector<XrExtensionProperties> properties(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
  if (auto done = succeeded(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, properties.data()),
                            "xrEnumerateInstanceExtensionProperties");
      !done)
    return tl::unexpected(done.error());
  std::vector<std::string> names;
  for (const XrExtensionProperties& one : properties) names.emplace_back(one.extensionName);
  return names;
}

/// Throws if the runtime or the driver refuses.
void require(XrResult result, VkResult vulkan, const char* name) {
  if (XR_FAILED(result)) throw std::runtime_error(error_of(result, name).what);
  if (vulkan != VK_SUCCESS)
    throw std::runtime_error(fmt::format("{}: {}", name, vk::to_string(static_cast<vk::Result>(vulkan))));
}

vk::Instance make_instance(XrInstance instance, XrSystemId system, const vk::InstanceCreateInfo& info) {
  const VkInstanceCreateInfo& plain = info;
  const XrVulkanInstanceCreateInfoKHR create{
      XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR, nullptr, system, 0, &vkGetInstanceProcAddr, &plain, nullptr};
  VkInstance made = VK_NULL_HANDLE;
  VkResult vulkan = VK_SUCCESS;
  const XrResult result = call<PFN_xrCreateVulkanInstanceKHR>(instance, "xrCreateVulkanInstanceKHR", instance,
                                                              &create, &made, &vulkan);
  require(result, vulkan, "xrCreateVulkanInstanceKHR");
  return made;
}

/// The GPU that the headset is driven by.
XrResult driving_device(XrInstance instance, XrSystemId system, vk::Instance vulkan,
                        vk::PhysicalDevice& found) {
  const XrVulkanGraphicsDeviceGetInfoKHR wanted{XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR, nullptr, system,
                                                vulkan};
  VkPhysicalDevice device = VK_NULL_HANDLE;
  const XrResult result = call<PFN_xrGetVulkanGraphicsDevice2KHR>(instance, "xrGetVulkanGraphicsDevice2KHR",
                                                                  instance, &wanted, &device);
  found = device;
  return result;
}

vk::PhysicalDevice choose_device(XrInstance instance, XrSystemId system, vk::Instance vulkan) {
  vk::PhysicalDevice device;
  require(driving_device(instance, system, vulkan, device), VK_SUCCESS, "xrGetVulkanGraphicsDevice2KHR");
  return device;
}

vk::Device make_device(XrInstance instance, XrSystemId system, vk::PhysicalDevice physical,
                       const vk::DeviceCreateInfo& info) {
  const VkDeviceCreateInfo& plain = info;
  const XrVulkanDeviceCreateInfoKHR create{XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR,
                                           nullptr,
                                           system,
                                           0,
                                           &vkGetInstanceProcAddr,
                                           physical,
                                           &plain,
                                           nullptr};
  VkDevice made = VK_NULL_HANDLE;
  VkResult vulkan = VK_SUCCESS;
  const XrResult result = call<PFN_xrCreateVulkanDeviceKHR>(instance, "xrCreateVulkanDeviceKHR", instance,
                                                            &create, &made, &vulkan);
  require(result, vulkan, "xrCreateVulkanDeviceKHR");
  return made;
}

std::string text_of(XrVersion version) {
  return fmt::format("{}.{}.{}", XR_VERSION_MAJOR(version), XR_VERSION_MINOR(version),
                     XR_VERSION_PATCH(version));
}

}  // namespace

Expected<std::unique_ptr<HeadsetSystem>> Instance::open() {
  std::unique_ptr<Instance> instance(new Instance);
  Expected<void> done = instance->create();
  if (done) done = instance->find_system();
  if (done) done = instance->read_views();
  if (done) done = instance->check_vulkan();
  if (!done) return tl::unexpected(done.error());
  instance->read_name();
  return instance;
}

Expected<void> Instance::create() {
  const Expected<std::vector<std::string>> offered = offered_extensions();
  if (!offered) return tl::unexpected(offered.error());
  std::vector<const char*> used{kVulkan};
  const auto use = [&](const char* extension) {
    const bool is_offered = std::ranges::find(*offered, extension) != offered->end();
    if (is_offered) used.push_back(extension);
    return is_offered;
  };
  extensions_.depth_layers = use(kDepthLayers);
  extensions_.visibility_mask = use(XR_KHR_VISIBILITY_MASK_EXTENSION_NAME);
  extensions_.refresh_rate = use(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME);
  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO, nullptr, 0, {}, 0, nullptr, 0, nullptr};
  std::strcpy(info.applicationInfo.applicationName, "Farshade");
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  info.enabledExtensionCount = static_cast<std::uint32_t>(used.size());
  info.enabledExtensionNames = used.data();
  return succeeded(xrCreateInstance(&info, &handle_), "xrCreateInstance");
}

Expected<void> Instance::find_system() {
  const XrSystemGetInfo wanted{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  return succeeded(xrGetSystem(handle_, &wanted, &system_), "xrGetSystem");
}

/// A runtime refuses sessions of a system whose requirements and device were not asked for.
Expected<void> Instance::find_again(const gpu::Device& device) {
  if (auto done = find_system(); !done) return done;
  if (auto done = check_vulkan(); !done) return done;
  vk::PhysicalDevice driven;
  const XrResult result = driving_device(handle_, system_, *device.instance, driven);
  if (auto done = succeeded(result, "xrGetVulkanGraphicsDevice2KHR"); !done) return done;
  if (driven == *device.physical) return {};
  return fail(Fault::Unavailable,
              "the headset is now driven by another GPU than the one that draws: start the client again");
}

Expected<void> Instance::read_views() {
  std::vector<XrViewConfigurationView> views(2, {XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, 0, 0, 0, 0, 0, 0});
  auto count = static_cast<std::uint32_t>(views.size());
  if (auto done =
          succeeded(xrEnumerateViewConfigurationViews(handle_, system_, kViews, count, &count, views.data()),
                    "xrEnumerateViewConfigurationViews");
      !done)
    return done;
  for (const XrViewConfigurationView& view : views) {
    recommended_.width = std::max(recommended_.width, view.recommendedImageRectWidth);
    recommended_.height = std::max(recommended_.height, view.recommendedImageRectHeight);
    largest_.width = std::max(largest_.width, view.maxImageRectWidth);
    largest_.height = std::max(largest_.height, view.maxImageRectHeight);
  }
  return {};
}

/// The runtime must be asked before a session is made. Its upper limit is the newest version that it was
/// tested with; drivers are compatible beyond it.
Expected<void> Instance::check_vulkan() const {
  XrGraphicsRequirementsVulkanKHR needs{XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR, nullptr, 0, 0};
  const XrResult result = call<PFN_xrGetVulkanGraphicsRequirements2KHR>(
      handle_, "xrGetVulkanGraphicsRequirements2KHR", handle_, system_, &needs);
  if (auto done = succeeded(result, "xrGetVulkanGraphicsRequirements2KHR"); !done) return done;
  if (needs.minApiVersionSupported <= XR_MAKE_VERSION(1, 3, 0)) return {};
  return fail(Fault::Unsupported, "the OpenXR runtime needs Vulkan " + text_of(needs.minApiVersionSupported) +
                                      ", and this client is written for Vulkan 1.3");
}

void Instance::read_name() {
  XrInstanceProperties runtime{XR_TYPE_INSTANCE_PROPERTIES, nullptr, 0, {}};
  XrSystemProperties system{XR_TYPE_SYSTEM_PROPERTIES, nullptr, 0, 0, {}, {}, {}};
  if (XR_FAILED(xrGetInstanceProperties(handle_, &runtime)) ||
      XR_FAILED(xrGetSystemProperties(handle_, system_, &system)))
    return;  // a name is only for people
  name_ = fmt::format("{} {}, {}", runtime.runtimeName, text_of(runtime.runtimeVersion), system.systemName);
}

Instance::~Instance() {
  if (handle_ != XR_NULL_HANDLE) xrDestroyInstance(handle_);
}

Extent Instance::eye_size(double scale) const {
  const auto side = [scale](std::uint32_t recommended, std::uint32_t largest) {
    const double most = std::min(largest, kMaxViewSide_px);
    return static_cast<std::uint32_t>(std::clamp(std::round(recommended * scale), 1.0, std::max(most, 1.0)));
  };
  return {side(recommended_.width, largest_.width), side(recommended_.height, largest_.height)};
}

gpu::VulkanMaker Instance::vulkan() const {
  return {.make_instance =
              [this](const vk::InstanceCreateInfo& info) { return make_instance(handle_, system_, info); },
          .choose_device = [this](vk::Instance vulkan) { return choose_device(handle_, system_, vulkan); },
          .make_device =
              [this](vk::PhysicalDevice physical, const vk::DeviceCreateInfo& info) {
                return make_device(handle_, system_, physical, info);
              }};
}

}  // namespace farshade::openxr

namespace farshade {

Expected<std::unique_ptr<HeadsetSystem>> HeadsetSystem::open() {
  return openxr::Instance::open();
}

}  // namespace farshade
