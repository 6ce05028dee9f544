// Sessions, their spaces and swapchains.
#include "tests/support/fake_openxr/runtime.h"

namespace farshade::fake_openxr {
namespace {

constexpr std::uint32_t kImages = 3;

XrResult create_session(XrInstance, const XrSessionCreateInfo* info, XrSession* session) {
  State& all = state();
  if (info->systemId != all.script.system) return XR_ERROR_SYSTEM_INVALID;
  if (!all.asked.contains(info->systemId)) return XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING;
  if (!all.sessions.empty()) return XR_ERROR_LIMIT_REACHED;
  const auto* const graphics = static_cast<const XrGraphicsBindingVulkanKHR*>(info->next);
  if (!graphics || graphics->type != XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR)
    return XR_ERROR_GRAPHICS_DEVICE_INVALID;
  *session = all.script.session = all.new_handle<XrSession>();
  all.sessions[*session] = {.physical = graphics->physicalDevice, .device = graphics->device};
  ++all.script.living.sessions;
  all.script.push(XR_SESSION_STATE_IDLE);
  all.script.push(XR_SESSION_STATE_READY);
  return XR_SUCCESS;
}

void destroy(const SwapchainParts& swapchain) {
  for (VkImage image : swapchain.images) vkDestroyImage(swapchain.device, image, nullptr);
  for (VkDeviceMemory memory : swapchain.memories) vkFreeMemory(swapchain.device, memory, nullptr);
}

XrResult destroy_session(XrSession session) {
  State& all = state();
  if (all.sessions.erase(session) == 0)
    return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroySession of a session that does not exist");
  --all.script.living.sessions;
  const auto is_of_session = [session](const auto& one) { return one.second.session == session; };
  for (const auto& [handle, swapchain] : all.swapchains)
    if (swapchain.session == session) destroy(swapchain);
  all.script.living.swapchains -= static_cast<int>(std::erase_if(all.swapchains, is_of_session));
  all.script.living.spaces -= static_cast<int>(std::erase_if(all.spaces, is_of_session));
  return XR_SUCCESS;
}

XrResult begin_session(XrSession session, const XrSessionBeginInfo* info) {
  State& all = state();
  SessionParts& parts = all.sessions.at(session);
  if (info->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
    return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  if (parts.is_running) return misuse(XR_ERROR_SESSION_RUNNING, "xrBeginSession of a session that runs");
  if (parts.state != XR_SESSION_STATE_READY)
    return misuse(XR_ERROR_SESSION_NOT_READY, "xrBeginSession of a session that is not ready");
  parts.is_running = true;
  for (const XrSessionState next : all.script.after_begin) all.script.push(next);
  return XR_SUCCESS;
}

XrResult end_session(XrSession session) {
  State& all = state();
  SessionParts& parts = all.sessions.at(session);
  if (!parts.is_running)
    return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrEndSession of a session that does not run");
  if (parts.state != XR_SESSION_STATE_STOPPING)
    return misuse(XR_ERROR_SESSION_NOT_STOPPING, "xrEndSession of a session that does not stop");
  parts.is_running = false;
  parts.frame = SessionParts::Frame::None;
  all.script.push(XR_SESSION_STATE_IDLE);
  if (parts.exits) all.script.push(XR_SESSION_STATE_EXITING);
  return XR_SUCCESS;
}

XrResult request_exit(XrSession session) {
  State& all = state();
  SessionParts& parts = all.sessions.at(session);
  if (!parts.is_running)
    return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrRequestExitSession of a session that does not run");
  if (all.script.ignores_exit) return XR_SUCCESS;
  parts.exits = true;
  for (const XrSessionState next :
       {XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING})
    all.script.push(next);
  return XR_SUCCESS;
}

XrResult enumerate_spaces(XrSession, std::uint32_t capacity, std::uint32_t* count,
                          XrReferenceSpaceType* types) {
  return enumerate<XrReferenceSpaceType>(state().script.spaces, capacity, count, types);
}

XrResult create_space(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space) {
  State& all = state();
  if (info->referenceSpaceType != XR_REFERENCE_SPACE_TYPE_VIEW &&
      std::ranges::find(all.script.spaces, info->referenceSpaceType) == all.script.spaces.end())
    return XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
  *space = all.new_handle<XrSpace>();
  all.spaces[*space] = {.session = session, .action = {}};
  ++all.script.living.spaces;
  return XR_SUCCESS;
}

XrResult destroy_space(XrSpace space) {
  if (state().spaces.erase(space) == 0)
    return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroySpace of a space that does not exist");
  --state().script.living.spaces;
  return XR_SUCCESS;
}

XrResult enumerate_formats(XrSession, std::uint32_t capacity, std::uint32_t* count, std::int64_t* formats) {
  return enumerate<std::int64_t>(state().script.formats, capacity, count, formats);
}

VkImageUsageFlags usage_of(XrSwapchainUsageFlags flags) {
  VkImageUsageFlags usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  if (flags & XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT) usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  if (flags & XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT)
    usage |= VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  if (flags & XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT) usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  if (flags & XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT) usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  return usage;
}

/// Adds an image with its memory. False if the device refuses.
bool add_image(SwapchainParts& parts, VkPhysicalDevice physical, const XrSwapchainCreateInfo& info) {
  VkImageCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  create.imageType = VK_IMAGE_TYPE_2D;
  create.format = static_cast<VkFormat>(info.format);
  create.extent = {info.width, info.height, 1};
  create.mipLevels = info.mipCount;
  create.arrayLayers = info.arraySize;
  create.samples = VK_SAMPLE_COUNT_1_BIT;
  create.tiling = VK_IMAGE_TILING_OPTIMAL;
  create.usage = usage_of(info.usageFlags);
  VkImage& image = parts.images.emplace_back(VK_NULL_HANDLE);
  if (vkCreateImage(parts.device, &create, nullptr, &image) != VK_SUCCESS) return false;
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(parts.device, image, &needs);
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(physical, &memory);
  VkMemoryAllocateInfo allocate{};
  allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  allocate.allocationSize = needs.size;
  for (std::uint32_t type = memory.memoryTypeCount; type-- > 0;)
    if (needs.memoryTypeBits >> type & 1u) allocate.memoryTypeIndex = type;
  VkDeviceMemory& made = parts.memories.emplace_back(VK_NULL_HANDLE);
  return vkAllocateMemory(parts.device, &allocate, nullptr, &made) == VK_SUCCESS &&
         vkBindImageMemory(parts.device, image, made, 0) == VK_SUCCESS;
}

XrResult create_swapchain(XrSession session, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain) {
  State& all = state();
  if (std::ranges::find(all.script.formats, info->format) == all.script.formats.end())
    return XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
  for (const EyeSize& size : all.script.sizes)
    if (info->width > size.largest_width || info->height > size.largest_height)
      return misuse(XR_ERROR_VALIDATION_FAILURE, "xrCreateSwapchain beyond the largest size");
  SwapchainParts parts{
      .session = session, .device = all.sessions.at(session).device, .images = {}, .memories = {}};
  for (std::uint32_t image = 0; image < kImages; ++image)
    if (!add_image(parts, all.sessions.at(session).physical, *info)) {
      destroy(parts);
      return XR_ERROR_OUT_OF_MEMORY;
    }
  *swapchain = all.new_handle<XrSwapchain>();
  all.swapchains[*swapchain] = parts;
  ++all.script.living.swapchains;
  all.script.swapchains.push_back({info->format, info->width, info->height, info->arraySize});
  return XR_SUCCESS;
}

XrResult destroy_swapchain(XrSwapchain swapchain) {
  const auto found = state().swapchains.find(swapchain);
  if (found == state().swapchains.end())
    return misuse(XR_ERROR_HANDLE_INVALID, "xrDestroySwapchain of a swapchain that does not exist");
  destroy(found->second);
  state().swapchains.erase(found);
  --state().script.living.swapchains;
  return XR_SUCCESS;
}

XrResult enumerate_images(XrSwapchain swapchain, std::uint32_t capacity, std::uint32_t* count,
                          XrSwapchainImageBaseHeader* images) {
  std::vector<XrSwapchainImageVulkanKHR> all;
  for (VkImage image : state().swapchains.at(swapchain).images)
    all.push_back({XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR, nullptr, image});
  return enumerate<XrSwapchainImageVulkanKHR>(all, capacity, count,
                                              reinterpret_cast<XrSwapchainImageVulkanKHR*>(images));
}

}  // namespace

std::vector<Function> session_calls() {
  return {entry<"xrCreateSession", &create_session>(),
          entry<"xrDestroySession", &destroy_session>(),
          entry<"xrBeginSession", &begin_session>(),
          entry<"xrEndSession", &end_session>(),
          entry<"xrRequestExitSession", &request_exit>(),
          entry<"xrEnumerateReferenceSpaces", &enumerate_spaces>(),
          entry<"xrCreateReferenceSpace", &create_space>(),
          entry<"xrDestroySpace", &destroy_space>(),
          entry<"xrEnumerateSwapchainFormats", &enumerate_formats>(),
          entry<"xrCreateSwapchain", &create_swapchain>(),
          entry<"xrDestroySwapchain", &destroy_swapchain>(),
          entry<"xrEnumerateSwapchainImages", &enumerate_images>()};
}

}  // namespace farshade::fake_openxr
