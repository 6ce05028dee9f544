#include "vr_client/doctor/device_facts.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "stereo/gpu/device.h"
#include "stereo/gpu/loader.h"

namespace farshade {
namespace {

using nlohmann::ordered_json;

std::string version_text(std::uint32_t version) {
  return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) +
         "." + std::to_string(VK_API_VERSION_PATCH(version));
}

ordered_json limits_of(const vk::PhysicalDeviceLimits& limits) {
  return {{"maxImageDimension2D", limits.maxImageDimension2D},
          {"maxImageArrayLayers", limits.maxImageArrayLayers},
          {"maxUniformBufferRange", limits.maxUniformBufferRange},
          {"maxStorageBufferRange", limits.maxStorageBufferRange},
          {"maxPushConstantsSize", limits.maxPushConstantsSize},
          {"maxMemoryAllocationCount", limits.maxMemoryAllocationCount},
          {"maxPerStageDescriptorStorageBuffers", limits.maxPerStageDescriptorStorageBuffers},
          {"maxPerStageDescriptorSampledImages", limits.maxPerStageDescriptorSampledImages},
          {"maxPerStageDescriptorStorageImages", limits.maxPerStageDescriptorStorageImages},
          {"maxPerStageResources", limits.maxPerStageResources},
          {"maxBoundDescriptorSets", limits.maxBoundDescriptorSets},
          {"maxComputeSharedMemorySize", limits.maxComputeSharedMemorySize},
          {"maxComputeWorkGroupCount", limits.maxComputeWorkGroupCount},
          {"maxComputeWorkGroupInvocations", limits.maxComputeWorkGroupInvocations},
          {"maxComputeWorkGroupSize", limits.maxComputeWorkGroupSize},
          {"maxFramebufferLayers", limits.maxFramebufferLayers},
          {"minStorageBufferOffsetAlignment", limits.minStorageBufferOffsetAlignment},
          {"minUniformBufferOffsetAlignment", limits.minUniformBufferOffsetAlignment},
          {"nonCoherentAtomSize", limits.nonCoherentAtomSize},
          {"bufferImageGranularity", limits.bufferImageGranularity},
          {"optimalBufferCopyRowPitchAlignment", limits.optimalBufferCopyRowPitchAlignment},
          {"timestampPeriod_ns", limits.timestampPeriod}};
}

ordered_json queues_of(const gpu::Device& device) {
  ordered_json queues = ordered_json::array();
  for (const vk::QueueFamilyProperties& family : device.physical.getQueueFamilyProperties())
    queues.push_back({{"queues", family.queueCount},
                      {"flags", vk::to_string(family.queueFlags)},
                      {"timestamp_bits", family.timestampValidBits}});
  return queues;
}

ordered_json memory_of(const vk::PhysicalDeviceMemoryProperties& memory) {
  ordered_json heaps = ordered_json::array(), types = ordered_json::array();
  for (std::uint32_t i = 0; i < memory.memoryHeapCount; ++i)
    heaps.push_back(
        {{"bytes", memory.memoryHeaps[i].size}, {"flags", vk::to_string(memory.memoryHeaps[i].flags)}});
  for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i)
    types.push_back({{"heap", memory.memoryTypes[i].heapIndex},
                     {"flags", vk::to_string(memory.memoryTypes[i].propertyFlags)}});
  return {{"heaps", heaps}, {"types", types}};
}

ordered_json facts_of(const gpu::Device& device) {
  const auto chain =
      device.physical
          .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceVulkan11Properties,
                          vk::PhysicalDeviceVulkan12Properties, vk::PhysicalDeviceVulkan13Properties>();
  const vk::PhysicalDeviceProperties& properties = chain.get<vk::PhysicalDeviceProperties2>().properties;
  const auto& v11 = chain.get<vk::PhysicalDeviceVulkan11Properties>();
  const auto& v12 = chain.get<vk::PhysicalDeviceVulkan12Properties>();
  const auto& v13 = chain.get<vk::PhysicalDeviceVulkan13Properties>();
  ordered_json limits = limits_of(properties.limits);
  limits["maxMemoryAllocationSize"] = v11.maxMemoryAllocationSize;
  limits["maxBufferSize"] = v13.maxBufferSize;
  return {{"name", device.name},
          {"type", vk::to_string(properties.deviceType)},
          {"draws_on_the_cpu", device.is_cpu},
          {"chosen_because", device.why},
          {"vendor_id", properties.vendorID},
          {"device_id", properties.deviceID},
          {"driver", {{"name", v12.driverName.data()}, {"version", v12.driverInfo.data()}}},
          {"vulkan", version_text(properties.apiVersion)},
          {"loader", gpu::loader_version()},
          {"subgroup_size",
           {{"usual", v11.subgroupSize}, {"least", v13.minSubgroupSize}, {"most", v13.maxSubgroupSize}}},
          {"queue_family_used", device.queue_family},
          {"queue_families", queues_of(device)},
          {"memory", memory_of(device.memory)},
          {"limits", limits}};
}

}  // namespace

void add_device_facts(CLI::App& program, DeviceFactsOptions& options) {
  CLI::App* command = program.add_subcommand(
      "device", "Prints the Vulkan device that the client would draw on, with its limits, as JSON.");
  command->add_option("--gpu", options.gpu, "use only a device whose name contains this text");
}

Expected<std::string> device_facts(const DeviceFactsOptions& options) {
  return gpu::open_device({.name_contains = options.gpu}).map([](const gpu::Device& device) {
    return facts_of(device).dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  });
}

}  // namespace farshade
