/// Device: one Vulkan 1.3 device with one queue: a GPU if there is one, otherwise lavapipe. With validation
/// on, it keeps every message of the validation layers; tests expect none.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>
#include <vulkan/vulkan_raii.hpp>

#include "stereo/base/expected.h"
#include "stereo/gpu/device_options.h"
#include "stereo/gpu/foreign_device.h"
#include "stereo/gpu/formats.h"
#include "stereo/gpu/ledger.h"
#include "stereo/gpu/recording.h"

namespace farshade::gpu {

/// Messages of the validation layers. Thread-safe.
class ValidationLog {
 public:
  void add(std::string message);
  [[nodiscard]] std::vector<std::string> messages() const;

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> messages_;
};

/// What has been asked of the queue of a device. Thread-safe.
struct QueueUse {
  std::atomic<std::uint64_t> submissions{0};  ///< calls that submit commands
  std::atomic<std::uint64_t> waits{0};        ///< of the host for the device
  std::atomic<bool> abandoned{false};         ///< by abandon(): the queue must not be used
};

/// The longest uniform block that a device must allow. Almost every driver does.
inline constexpr std::uint32_t kUniformRange_bytes = 32 << 10;

struct Device {
  vk::raii::Context context;
  std::unique_ptr<ValidationLog> validation_log;  ///< null when validation is off
  vk::raii::Instance instance{nullptr};
  vk::raii::DebugUtilsMessengerEXT messenger{nullptr};
  vk::raii::PhysicalDevice physical{nullptr};
  vk::raii::Device logical{nullptr};
  vk::raii::Queue queue{nullptr};
  std::uint32_t queue_family = 0;
  bool presents = false;  ///< in the window of DeviceOptions::presentation
  vk::raii::CommandPool commands{nullptr};
  vk::raii::PipelineCache pipelines{nullptr};  ///< pipeline_cache.h fills and keeps it
  vk::PhysicalDeviceMemoryProperties memory;
  std::uint64_t max_allocations = 0;          ///< that may exist at one time (maxMemoryAllocationCount)
  std::uint64_t max_allocation_bytes = 0;     ///< of one allocation (maxMemoryAllocationSize)
  std::uint32_t max_image_side_px = 0;        ///< maxImageDimension2D
  std::uint32_t max_image_layers = 0;         ///< maxImageArrayLayers
  std::array<std::uint32_t, 2> max_groups{};  ///< of a dispatch along x and y (maxComputeWorkGroupCount)
  std::uint64_t max_storage_bytes = 0;        ///< of a storage buffer (maxStorageBufferRange)
  std::uint64_t max_texels = 0;               ///< of a buffer of texels (maxTexelBufferElements)
  /// Limits of the images of a format. Tests replace it.
  std::function<decltype(gpu::image_limits)> image_limits = gpu::image_limits;
  bool timelines = false;                                       ///< it has timeline semaphores
  std::shared_ptr<Ledger> ledger = std::make_shared<Ledger>();  ///< of all memory allocated on the device
  std::shared_ptr<QueueUse> use = std::make_shared<QueueUse>();
  std::uint64_t timeout_ns = kGpuTimeout_ns;  ///< of waits for the device
  float timestamp_period_ns = 1;              ///< of one timestamp tick
  std::uint32_t timestamp_bits = 64;          ///< that count; those above are undefined
  bool is_cpu = false;                        ///< it draws on the processor, as lavapipe does
  bool is_adopted = false;                    ///< somebody else has made it, and destroys it
  std::string name;
  std::string why;  ///< one clause: why this device was chosen, and why others were not
};

/// The best device that `options` allow. Fault::Missing if there is none; the error names what each device
/// lacks.
[[nodiscard]] Expected<Device> open_device(const DeviceOptions& options);

/// Uses a device without owning it: it must outlive the result, which destroys only what was made on it.
/// Fault::Missing if it lacks something; the error names what.
[[nodiscard]] Expected<Device> adopt_device(const ForeignDevice& foreign);

/// Names `handle` in validation messages and debuggers. Does nothing when validation is off.
template <class Handle>
void set_name(const Device& device, const Handle& handle, const std::string& name) {
  if (!device.validation_log) return;
  device.logical.setDebugUtilsObjectNameEXT(
      {.objectType = Handle::objectType,
       .objectHandle = reinterpret_cast<std::uint64_t>(static_cast<typename Handle::CType>(*handle)),
       .pObjectName = name.c_str()});
}

/// From now on nothing that was made on `device`, nor the device itself, is really destroyed: the handles and
/// their memory leak. For a device that did not finish in time: it may still use any of them, and destroying
/// what is in use crashes the driver. The device must not be used for anything else any more. `exit` then
/// flushes the standard streams and ends the program at once: no static object is destroyed. If the device
/// is adopted, `exit` does what it does otherwise.
void abandon(const Device& device);

/// Calls `record` with a command buffer, submits the buffer and waits for it. Throws after
/// Device::timeout_ns, so that a driver that hangs does not hang the program.
template <class Record>
void run_now(const Device& device, Record&& record);

/// Submits `commands` with `fence` and waits for the fence. After Device::timeout_ns, abandons the device and
/// throws vk::DeviceLostError.
void submit_and_wait(const Device& device, const vk::raii::CommandBuffer& commands,
                     const vk::raii::Fence& fence);

/// Calls `wait` with a time in nanoseconds until it returns eSuccess, for Device::timeout_ns in all. Returns
/// whether it did. Waits in steps: a program that was stopped for longer than the timeout (Ctrl-Z) finds that
/// one of them is over.
template <class Wait>
[[nodiscard]] bool finishes_in_time(const Device& device, const Wait& wait);

/// Calls `use`, which uses the device. Memory that it has not got is reported as a lost device, too
/// (vk::DeviceLostError): the device must then be opened again.
template <class Use>
void losing_device(const Use& use);

template <class Wait>
bool finishes_in_time(const Device& device, const Wait& wait) {
  constexpr std::uint64_t kSteps = 10;
  for (std::uint64_t step = 0; step < kSteps; ++step)
    if (wait(device.timeout_ns / kSteps) == vk::Result::eSuccess) return true;
  return false;
}

template <class Use>
void losing_device(const Use& use) {
  try {
    use();
  } catch (const vk::OutOfHostMemoryError& error) {
    throw vk::DeviceLostError(error.what());
  } catch (const vk::OutOfDeviceMemoryError& error) {
    throw vk::DeviceLostError(error.what());
  }
}

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
