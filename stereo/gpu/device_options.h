/// DeviceOptions: which device open_device may choose. Headers of programs include this file; it does not
/// include Vulkan's headers, which take 4 s to compile.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vk {
class Device;
class Instance;
class PhysicalDevice;
struct DeviceCreateInfo;
struct InstanceCreateInfo;
}  // namespace vk

namespace farshade::gpu {

enum class Validation : std::uint8_t { Off, On };

/// Whether a device that cannot present may be chosen.
enum class Need : std::uint8_t { Required, Wished };

/// What a window system needs of a device to show pictures.
struct Presentation {
  std::vector<std::string> instance_extensions;
  std::function<bool(vk::Instance, vk::PhysicalDevice, std::uint32_t queue_family)> can_present;
  Need need = Need::Required;
};

/// Makes instance and device in place of the Vulkan loader, as a headset's runtime does. The functions throw
/// if they fail.
struct VulkanMaker {
  std::function<vk::Instance(const vk::InstanceCreateInfo&)> make_instance;
  std::function<vk::PhysicalDevice(vk::Instance)> choose_device;  ///< the only one that may be used
  std::function<vk::Device(vk::PhysicalDevice, const vk::DeviceCreateInfo&)> make_device;
};

inline constexpr std::uint64_t kGpuTimeout_ns = 30'000'000'000;

struct DeviceOptions {
  std::string name_contains;  ///< only devices whose name contains this; empty = any
  Validation validation = Validation::Off;
  /// Set: only devices that can present, with VK_KHR_swapchain enabled. If it is only wished:
  /// Device::presents.
  std::optional<Presentation> presentation = std::nullopt;
  std::optional<VulkanMaker> maker = std::nullopt;  ///< empty: the Vulkan loader
  /// After it, a device that has not finished counts as lost; one that draws on the CPU after ten times as
  /// long.
  std::uint64_t timeout_ns = kGpuTimeout_ns;
};

}  // namespace farshade::gpu
