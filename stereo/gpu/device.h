/// Device: one Vulkan 1.3 device with one queue - a GPU if there is one, lavapipe otherwise - and why it was
/// chosen. With validation on, every message of the layers is counted and kept; tests demand none.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>
#include <vulkan/vulkan_raii.hpp>

#include "stereo/base/expected.h"
#include "stereo/gpu/ledger.h"

namespace farshade::gpu {

/// What the validation layers said, from any thread.
class ValidationLog {
 public:
  void add(std::string message);
  [[nodiscard]] std::vector<std::string> messages() const;

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> messages_;
};

enum class Validation : std::uint8_t { Off, On };

/// What it takes to show pictures in a window, as the window's system states it.
struct Presentation {
  std::vector<std::string> instance_extensions;
  std::function<bool(vk::Instance, vk::PhysicalDevice, std::uint32_t queue_family)> can_present;
};

struct DeviceOptions {
  std::string name_contains;  ///< only devices whose name contains this; empty = the best there is
  Validation validation = Validation::Off;
  std::optional<Presentation> presentation = std::nullopt;  ///< only devices that can; adds VK_KHR_swapchain
};

struct Device {
  vk::raii::Context context;
  std::unique_ptr<ValidationLog> validation_log;  ///< null when validation is off
  vk::raii::Instance instance{nullptr};
  vk::raii::DebugUtilsMessengerEXT messenger{nullptr};
  vk::raii::PhysicalDevice physical{nullptr};
  vk::raii::Device logical{nullptr};
  vk::raii::Queue queue{nullptr};
  std::uint32_t queue_family = 0;
  vk::raii::CommandPool commands{nullptr};
  vk::PhysicalDeviceMemoryProperties memory;
  std::shared_ptr<Ledger> ledger = std::make_shared<Ledger>();  ///< of everything allocated on the device
  float timestamp_period_ns = 1;                                ///< of one timestamp tick
  std::string name;
  std::string why;  ///< one clause: why this one and what was passed over
};

/// Refuses with Fault::Missing, naming for each device what it lacks.
[[nodiscard]] Expected<Device> open_device(const DeviceOptions& wish);

/// What open_device would see and do.
struct SurveyedDevice {
  std::string name, kind, api;
  std::string driver;       ///< its name and version; empty where the device is too old to say
  std::string passed_over;  ///< why; empty: this is the one that is taken
};
struct Survey {
  std::string loader;                       ///< version
  Validation validation = Validation::Off;  ///< whether the layers are installed
  std::vector<SurveyedDevice> devices;      ///< none where there is no driver
};

/// Every device here and the verdict on it. Missing where not even the loader answers.
[[nodiscard]] Expected<Survey> survey(const DeviceOptions& wish);

/// Names `handle` for validation messages and captures; nothing when validation is off.
template <class Handle>
void set_name(const Device& device, const Handle& handle, const std::string& name) {
  if (!device.validation_log) return;
  device.logical.setDebugUtilsObjectNameEXT(
      {.objectType = Handle::objectType,
       .objectHandle = reinterpret_cast<std::uint64_t>(static_cast<typename Handle::CType>(*handle)),
       .pObjectName = name.c_str()});
}

/// Records with `record`, submits, and waits. Waits at most kGpuTimeout, then throws: a driver that hangs
/// must not hang us.
template <class Record>
void run_now(const Device& device, Record&& record);

inline constexpr std::uint64_t kGpuTimeout_ns = 30'000'000'000;

/// Submits `commands` with `fence` and waits for it.
void submit_and_wait(const Device& device, const vk::raii::CommandBuffer& commands,
                     const vk::raii::Fence& fence);

template <class Record>
void run_now(const Device& device, Record&& record) {
  auto buffers = device.logical.allocateCommandBuffers(
      {.commandPool = *device.commands, .level = vk::CommandBufferLevel::ePrimary, .commandBufferCount = 1});
  const vk::raii::Fence fence = device.logical.createFence({});
  buffers[0].begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  record(buffers[0]);
  buffers[0].end();
  submit_and_wait(device, buffers[0], fence);
}

}  // namespace farshade::gpu
