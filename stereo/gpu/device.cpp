#include "stereo/gpu/device.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace farshade::gpu {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

/// The types of the parameters depend on the version of the Vulkan headers.
constexpr auto on_message = [](auto /*severity*/, auto /*types*/, const auto* data, void* log) -> vk::Bool32 {
  static_cast<ValidationLog*>(log)->add(data->pMessage);
  return VK_FALSE;
};

vk::DebugUtilsMessengerCreateInfoEXT messenger_info(ValidationLog& log) {
  using Severity = vk::DebugUtilsMessageSeverityFlagBitsEXT;
  using Type = vk::DebugUtilsMessageTypeFlagBitsEXT;
  return {.messageSeverity = Severity::eWarning | Severity::eError,
          .messageType = Type::eValidation | Type::ePerformance,
          .pfnUserCallback = on_message,
          .pUserData = &log};
}

bool has_validation_layer(const vk::raii::Context& context) {
  const auto layers = context.enumerateInstanceLayerProperties();
  return std::any_of(layers.begin(), layers.end(), [](const vk::LayerProperties& layer) {
    return std::strcmp(layer.layerName, kValidationLayer) == 0;
  });
}

vk::raii::Instance make_instance(const vk::raii::Context& context, ValidationLog* log,
                                 const DeviceOptions& options) {
  const vk::ApplicationInfo app{.pApplicationName = "farshade", .apiVersion = VK_API_VERSION_1_3};
  std::vector<const char*> extensions;
  if (options.presentation)
    for (const std::string& name : options.presentation->instance_extensions)
      extensions.push_back(name.c_str());
  vk::InstanceCreateInfo info{.pApplicationInfo = &app};
  vk::DebugUtilsMessengerCreateInfoEXT messenger;
  if (log) {
    messenger = messenger_info(*log);
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    info.pNext = &messenger;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
  }
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  if (options.maker) return vk::raii::Instance(context, options.maker->make_instance(info));
  return vk::raii::Instance(context, info);
}

/// `options` without a presentation that is only wished and that the loader has no extensions for.
DeviceOptions possible(DeviceOptions options, const vk::raii::Context& context) {
  if (!options.presentation || options.presentation->need == Need::Required) return options;
  const auto offered = context.enumerateInstanceExtensionProperties();
  const auto is_offered = [&](const std::string& name) {
    return std::ranges::any_of(offered, [&](const auto& one) { return name == one.extensionName.data(); });
  };
  const auto& names = options.presentation->instance_extensions;
  if (names.empty() || !std::ranges::all_of(names, is_offered)) options.presentation.reset();
  return options;
}

bool must_present(const DeviceOptions& options) {
  return options.presentation && options.presentation->need == Need::Required;
}

bool has_extension(const vk::raii::PhysicalDevice& physical, const char* name) {
  return std::ranges::any_of(physical.enumerateDeviceExtensionProperties(), [&](const auto& extension) {
    return std::strcmp(extension.extensionName, name) == 0;
  });
}

/// A maker may add feature structures of its own to ours, which must not be beside
/// VkPhysicalDeviceVulkan12Features (VUID-VkDeviceCreateInfo-pNext-02830). This extension has the one feature
/// of that structure that we need. Its other one, timeline semaphores (every device of Vulkan 1.2 has them),
/// a maker may or may not enable: such a device has fences in their place.
constexpr const char* kLayeredDrawing = VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME;

/// A family whose queues draw, compute and keep time.
struct QueueFamily {
  std::uint32_t index;
  std::uint32_t timestamp_bits;
  bool presents;  ///< and show in the window
};

/// The first family that presents, or the first one if none does and none has to.
std::optional<QueueFamily> graphics_queue_family(const vk::raii::Instance& instance,
                                                 const vk::raii::PhysicalDevice& physical,
                                                 const DeviceOptions& options) {
  const auto families = physical.getQueueFamilyProperties();
  const vk::QueueFlags required = vk::QueueFlagBits::eGraphics | vk::QueueFlagBits::eCompute;
  const bool swaps = options.presentation && has_extension(physical, VK_KHR_SWAPCHAIN_EXTENSION_NAME);
  std::optional<QueueFamily> found;
  for (std::uint32_t i = 0; i < families.size(); ++i) {
    const std::uint32_t bits = families[i].timestampValidBits;
    if ((families[i].queueFlags & required) != required || bits == 0) continue;
    if (swaps && options.presentation->can_present(*instance, *physical, i))
      return QueueFamily{i, bits, true};
    if (!found && !must_present(options)) found = QueueFamily{i, bits, false};
  }
  return found;
}

/// What the device lacks of what every pass needs; empty if nothing.
std::string lacks(const vk::raii::PhysicalDevice& physical) {
  const vk::PhysicalDeviceProperties properties = physical.getProperties();
  if (properties.apiVersion < VK_API_VERSION_1_3) return "no Vulkan 1.3";
  if (properties.limits.maxUniformBufferRange < kUniformRange_bytes)
    return "uniform buffers of " + std::to_string(properties.limits.maxUniformBufferRange) + " bytes, and " +
           std::to_string(kUniformRange_bytes) + " are needed";
  const std::string format =
      lacking_format([&](vk::Format one) { return physical.getFormatProperties(one).optimalTilingFeatures; });
  if (!format.empty()) return format;
  const auto features = physical.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features,
                                              vk::PhysicalDeviceVulkan13Features>();
  if (!features.get<vk::PhysicalDeviceVulkan12Features>().shaderOutputLayer) return "no layered drawing";
  if (!features.get<vk::PhysicalDeviceVulkan13Features>().dynamicRendering) return "no dynamic rendering";
  if (!features.get<vk::PhysicalDeviceVulkan13Features>().synchronization2) return "no synchronization2";
  if (!features.get<vk::PhysicalDeviceVulkan13Features>().maintenance4) return "no maintenance4";
  return {};
}

/// What the device lacks; empty if it is usable.
std::string lacks(const vk::raii::Instance& instance, const vk::raii::PhysicalDevice& physical,
                  const DeviceOptions& options) {
  if (std::string(physical.getProperties().deviceName).find(options.name_contains) == std::string::npos)
    return "its name lacks '" + options.name_contains + "'";
  if (std::string lacking = lacks(physical); !lacking.empty()) return lacking;
  if (options.maker && !has_extension(physical, kLayeredDrawing)) return "no layered drawing";
  if (must_present(options) && !has_extension(physical, VK_KHR_SWAPCHAIN_EXTENSION_NAME))
    return "no swapchains";
  if (!graphics_queue_family(instance, physical, options))
    return must_present(options) ? "no queue that draws, computes, keeps time and shows in this window"
                                 : "no queue that draws, computes and keeps time";
  return {};
}

int preference(vk::PhysicalDeviceType type) {
  switch (type) {
    case vk::PhysicalDeviceType::eDiscreteGpu:
      return 3;
    case vk::PhysicalDeviceType::eIntegratedGpu:
      return 2;
    case vk::PhysicalDeviceType::eVirtualGpu:
      return 1;
    default:
      return 0;
  }
}

/// A device and why it is not chosen; empty for the chosen one.
struct Judged {
  vk::raii::PhysicalDevice physical;
  std::string passed_over;
};

/// All devices in the loader's order. At most one is chosen.
std::vector<Judged> judge(const vk::raii::Instance& instance, const DeviceOptions& options) {
  std::vector<Judged> judged;
  std::optional<std::size_t> best;
  const auto only = options.maker ? std::optional(options.maker->choose_device(*instance)) : std::nullopt;
  for (vk::raii::PhysicalDevice& physical : vk::raii::PhysicalDevices(instance)) {
    std::string passed_over =
        only && *physical != *only ? "not that of the headset" : lacks(instance, physical, options);
    const int here = preference(physical.getProperties().deviceType);
    const bool usable = passed_over.empty();
    if (usable && best && here <= preference(judged[*best].physical.getProperties().deviceType)) {
      passed_over = "not better";
    } else if (usable) {
      if (best) judged[*best].passed_over = "less capable";
      best = judged.size();
    }
    judged.push_back({std::move(physical), std::move(passed_over)});
  }
  return judged;
}

/// "NAME: reason; ..." for the devices that are not chosen.
std::string reasons(const std::vector<Judged>& judged) {
  std::string text;
  for (const Judged& one : judged)
    if (!one.passed_over.empty())
      text += (text.empty() ? "" : "; ") + std::string(one.physical.getProperties().deviceName.data()) +
              ": " + one.passed_over;
  return text;
}

vk::raii::Device make_logical(const vk::raii::PhysicalDevice& physical, const QueueFamily& family,
                              const DeviceOptions& options) {
  vk::PhysicalDeviceVulkan13Features features13{
      .synchronization2 = true, .dynamicRendering = true, .maintenance4 = true};
  vk::PhysicalDeviceVulkan12Features features12{
      .pNext = &features13, .timelineSemaphore = true, .shaderOutputLayer = true};
  const float priority = 1;
  const vk::DeviceQueueCreateInfo queue{
      .queueFamilyIndex = family.index, .queueCount = 1, .pQueuePriorities = &priority};
  std::vector<const char*> extensions;
  if (family.presents) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
  if (options.maker) extensions.push_back(kLayeredDrawing);
  vk::DeviceCreateInfo info{.queueCreateInfoCount = 1, .pQueueCreateInfos = &queue};
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  if (options.maker)
    info.pNext = &features13;
  else
    info.pNext = &features12;
  if (options.maker) return vk::raii::Device(physical, options.maker->make_device(*physical, info));
  return vk::raii::Device(physical, info);
}

/// Fills what the fields of `device` say of its physical device.
/// `timeout_ns` is that of a GPU.
void read_limits(Device& device, std::uint64_t timeout_ns) {
  const vk::PhysicalDeviceProperties properties = device.physical.getProperties();
  device.name = properties.deviceName.data();
  device.is_cpu = properties.deviceType == vk::PhysicalDeviceType::eCpu;
  // A driver that draws on the CPU does not hang, but shares the cores with all other programs.
  device.timeout_ns = device.is_cpu ? 10 * timeout_ns : timeout_ns;
  device.timestamp_period_ns = properties.limits.timestampPeriod;
  device.max_allocations = properties.limits.maxMemoryAllocationCount;
  device.max_image_side_px = properties.limits.maxImageDimension2D;
  device.max_image_layers = properties.limits.maxImageArrayLayers;
  device.max_storage_bytes = properties.limits.maxStorageBufferRange;
  device.max_texels = properties.limits.maxTexelBufferElements;
  device.max_groups = {properties.limits.maxComputeWorkGroupCount[0],
                       properties.limits.maxComputeWorkGroupCount[1]};
  device.max_allocation_bytes =
      device.physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceVulkan11Properties>()
          .get<vk::PhysicalDeviceVulkan11Properties>()
          .maxMemoryAllocationSize;
  device.memory = device.physical.getMemoryProperties();
}

vk::raii::CommandPool make_command_pool(const Device& device) {
  return device.logical.createCommandPool(
      {.flags = vk::CommandPoolCreateFlagBits::eResetCommandBuffer, .queueFamilyIndex = device.queue_family});
}

/// Makes a function of Vulkan do nothing.
template <class Result, class... Arguments>
void silence(Result(VKAPI_PTR*& function)(Arguments...)) {
  function = [](Arguments...) { return Result(); };
}

/// The namespace of the type depends on the version of the Vulkan headers.
template <class Dispatcher>
Dispatcher& writable(const Dispatcher* functions) {
  return const_cast<Dispatcher&>(*functions);
}

}  // namespace

void ValidationLog::add(std::string message) {
  const std::lock_guard lock(mutex_);
  messages_.push_back(std::move(message));
}

std::vector<std::string> ValidationLog::messages() const {
  const std::lock_guard lock(mutex_);
  return messages_;
}

Expected<Device> open_device(const DeviceOptions& wanted) try {
  Device device;
  const DeviceOptions options = possible(wanted, device.context);
  if (options.validation == Validation::On) {
    if (!has_validation_layer(device.context))
      return fail(Fault::Missing,
                  "Vulkan validation layers are not installed (Debian: vulkan-validationlayers)");
    device.validation_log = std::make_unique<ValidationLog>();
  }
  device.instance = make_instance(device.context, device.validation_log.get(), options);
  if (device.validation_log)
    device.messenger = device.instance.createDebugUtilsMessengerEXT(messenger_info(*device.validation_log));

  std::vector<Judged> judged = judge(device.instance, options);
  const std::string passed_over = reasons(judged);
  const auto taken = std::ranges::find(judged, "", &Judged::passed_over);
  if (taken == judged.end())
    return fail(Fault::Missing, "no usable Vulkan 1.3 device (" +
                                    (passed_over.empty() ? std::string("none found") : passed_over) +
                                    "); install a driver, for example Debian's mesa-vulkan-drivers");
  device.physical = std::move(taken->physical);
  read_limits(device, options.timeout_ns);
  device.why = options.maker   ? "that of the headset"
               : device.is_cpu ? "no GPU was usable, drawing on the CPU"
                               : "the most capable device";
  if (!passed_over.empty()) device.why += " (passed over: " + passed_over + ")";
  const QueueFamily family = *graphics_queue_family(device.instance, device.physical, options);
  device.queue_family = family.index;
  device.timestamp_bits = family.timestamp_bits;
  device.presents = family.presents;
  device.logical = make_logical(device.physical, family, options);
  device.timelines = !options.maker;
  device.queue = device.logical.getQueue(device.queue_family, 0);
  device.commands = make_command_pool(device);
  return device;
} catch (const std::exception& error) {
  if (wanted.maker)
    return fail(Fault::Unavailable, std::string("no Vulkan device for the headset: ") + error.what());
  // The loader throws if there is no driver. That is a missing device, not a broken invariant.
  return fail(Fault::Missing, std::string("no usable Vulkan device: ") + error.what() +
                                  "; install a driver, for example Debian's mesa-vulkan-drivers");
}

Expected<Device> adopt_device(const ForeignDevice& foreign) try {
  Device device;
  device.instance = vk::raii::Instance(device.context, foreign.instance);
  // Both tables of functions are ours alone, so the owner still destroys what it owns.
  silence(writable(device.instance.getDispatcher()).vkDestroyInstance);
  device.physical = vk::raii::PhysicalDevice(device.instance, foreign.physical);
  if (const std::string lacking = lacks(device.physical); !lacking.empty())
    return fail(Fault::Missing, std::string(device.physical.getProperties().deviceName.data()) +
                                    " cannot be used: " + lacking);
  const auto families = device.physical.getQueueFamilyProperties();
  const vk::QueueFlags required = vk::QueueFlagBits::eGraphics | vk::QueueFlagBits::eCompute;
  if (foreign.queue_family >= families.size() ||
      (families[foreign.queue_family].queueFlags & required) != required)
    return fail(Fault::Missing, "the queue family does not draw and compute");
  device.logical = vk::raii::Device(device.physical, foreign.logical);
  silence(writable(device.logical.getDispatcher()).vkDestroyDevice);
  device.queue_family = foreign.queue_family;
  device.timestamp_bits = families[foreign.queue_family].timestampValidBits;
  device.queue = vk::raii::Queue(device.logical, foreign.queue);
  read_limits(device, kGpuTimeout_ns);
  device.is_adopted = true;
  device.why = "that of another renderer";
  device.commands = make_command_pool(device);
  return device;
} catch (const vk::SystemError& error) {
  return fail(Fault::Missing, std::string("the device cannot be used: ") + error.what());
}

/// Handles are destroyed by destructors, also of objects that an exception leaves behind half made. All of
/// them call the device's table of functions. At the end of the program the driver's threads may still run,
/// and crash when the static objects of its libraries are destroyed: so none is.
void abandon(const Device& device) {
  device.use->abandoned = true;
  if (!device.is_adopted)
    on_exit(
        [](int status, void*) {
          std::fflush(nullptr);
          std::_Exit(status);
        },
        nullptr);
  auto& call = writable(device.logical.getDispatcher());
  silence(call.vkDestroyDevice);
  silence(call.vkDeviceWaitIdle);
  silence(call.vkWaitSemaphores);
  silence(call.vkFreeMemory);
  silence(call.vkDestroyFence);
  silence(call.vkDestroySemaphore);
  silence(call.vkDestroyQueryPool);
  silence(call.vkDestroyBuffer);
  silence(call.vkDestroyBufferView);
  silence(call.vkDestroyImage);
  silence(call.vkDestroyImageView);
  silence(call.vkDestroyShaderModule);
  silence(call.vkDestroyPipelineCache);
  silence(call.vkDestroyPipeline);
  silence(call.vkDestroyPipelineLayout);
  silence(call.vkDestroySampler);
  silence(call.vkDestroyDescriptorSetLayout);
  silence(call.vkDestroyDescriptorPool);
  silence(call.vkFreeDescriptorSets);
  silence(call.vkDestroyFramebuffer);
  silence(call.vkDestroyRenderPass);
  silence(call.vkDestroyCommandPool);
  silence(call.vkFreeCommandBuffers);
  silence(call.vkDestroySwapchainKHR);
  // The swapchains stay on their surface, and the instance ends its devices with it.
  silence(writable(device.instance.getDispatcher()).vkDestroySurfaceKHR);
  silence(writable(device.instance.getDispatcher()).vkDestroyInstance);
}

void submit_and_wait(const Device& device, const vk::raii::CommandBuffer& commands,
                     const vk::raii::Fence& fence) {
  const vk::CommandBuffer handle = *commands;
  losing_device([&] {
    ++device.use->submissions;
    device.queue.submit(vk::SubmitInfo{.commandBufferCount = 1, .pCommandBuffers = &handle}, *fence);
    ++device.use->waits;
    const bool in_time = finishes_in_time(
        device, [&](std::uint64_t step_ns) { return device.logical.waitForFences(*fence, true, step_ns); });
    if (!in_time) {
      abandon(device);
      throw vk::DeviceLostError("vkWaitForFences: the device did not finish in time and was abandoned");
    }
    device.logical.resetFences(*fence);
  });
}

}  // namespace farshade::gpu
