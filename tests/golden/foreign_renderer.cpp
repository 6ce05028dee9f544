#include "tests/golden/foreign_renderer.h"

#include <vulkan/vulkan.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <stdexcept>

#include "stereo/base/check.h"
#include "stereo/gpu/device_options.h"
#include "stereo/raster/frame_data.h"
#include "tests/golden/foreign.frag.spv.h"
#include "tests/golden/foreign.vert.spv.h"
#include "tests/support/test_place.h"

namespace farshade {
namespace {

void must(VkResult result, const char* call) {
  if (result != VK_SUCCESS)
    throw std::runtime_error(std::string(call) + " gives " + std::to_string(static_cast<int>(result)));
}

VKAPI_ATTR VkBool32 VKAPI_CALL keep_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                            VkDebugUtilsMessageTypeFlagsEXT,
                                            const VkDebugUtilsMessengerCallbackDataEXT* data,
                                            void* messages) {
  static_cast<std::vector<std::string>*>(messages)->push_back(data->pMessage);
  return VK_FALSE;
}

template <class Function>
Function function_of(VkInstance instance, const char* name) {
  return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

/// The push constants of foreign.vert.
struct Drawn {
  glm::mat4 clip_from_object;
  std::array<glm::vec4, 3> stage_from_object_normal;
  float step_y;
  std::uint32_t instance;
};

struct Corner {
  glm::vec3 position, normal;
};

constexpr VkFormat kDepth = VK_FORMAT_D32_SFLOAT, kSurfaces = VK_FORMAT_R32G32_UINT;
constexpr VkPipelineStageFlags2 kDraws = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT |
                                         VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT |
                                         VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
constexpr VkAccessFlags2 kDrawn = VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
                                  VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
                                  VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;

/// One side of a barrier.
struct Side2 {
  VkPipelineStageFlags2 stages;
  VkAccessFlags2 access;
  VkImageLayout layout;
};

VkImageMemoryBarrier2 barrier_of(VkImage image, VkImageAspectFlags aspect, const Side2& from,
                                 const Side2& to) {
  VkImageMemoryBarrier2 barrier{};
  barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2;
  barrier.srcStageMask = from.stages;
  barrier.srcAccessMask = from.access;
  barrier.dstStageMask = to.stages;
  barrier.dstAccessMask = to.access;
  barrier.oldLayout = from.layout;
  barrier.newLayout = to.layout;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image;
  barrier.subresourceRange = {aspect, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
  return barrier;
}

void record_barriers(VkCommandBuffer commands, std::span<const VkImageMemoryBarrier2> images) {
  VkDependencyInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
  info.imageMemoryBarrierCount = narrow<std::uint32_t>(images.size());
  info.pImageMemoryBarriers = images.data();
  vkCmdPipelineBarrier2(commands, &info);
}

VkShaderModule make_shader(VkDevice device, std::span<const std::uint32_t> words) {
  VkShaderModuleCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  info.codeSize = words.size_bytes();
  info.pCode = words.data();
  VkShaderModule shader = nullptr;
  must(vkCreateShaderModule(device, &info, nullptr, &shader), "vkCreateShaderModule");
  return shader;
}

VkPipelineShaderStageCreateInfo stage_of(VkShaderStageFlagBits stage, VkShaderModule shader) {
  VkPipelineShaderStageCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage = stage;
  info.module = shader;
  info.pName = "main";
  return info;
}

/// All of the pipeline but its shaders. Its structs point to each other.
struct FixedState {
  explicit FixedState(Extent size)
      : viewport{0, 0, static_cast<float>(size.width), static_cast<float>(size.height), 0, 1},
        scissor{{0, 0}, {size.width, size.height}} {
    input.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;
    input.vertexBindingDescriptionCount = 1;
    input.pVertexBindingDescriptions = &binding;
    input.vertexAttributeDescriptionCount = narrow<std::uint32_t>(attributes.size());
    input.pVertexAttributeDescriptions = attributes.data();
    assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    viewports.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
    viewports.viewportCount = viewports.scissorCount = 1;
    viewports.pViewports = &viewport;
    viewports.pScissors = &scissor;
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.lineWidth = 1;
    samples.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    depth.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO;
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    written.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT;
    blend.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
    blend.attachmentCount = 1;
    blend.pAttachments = &written;
    dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
    dynamic.dynamicStateCount = narrow<std::uint32_t>(dynamics.size());
    dynamic.pDynamicStates = dynamics.data();
    rendering.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachmentFormats = &kSurfaces;
    rendering.depthAttachmentFormat = kDepth;
  }
  FixedState(const FixedState&) = delete;
  FixedState& operator=(const FixedState&) = delete;

  VkVertexInputBindingDescription binding{0, sizeof(Corner), VK_VERTEX_INPUT_RATE_VERTEX};
  std::array<VkVertexInputAttributeDescription, 2> attributes{
      VkVertexInputAttributeDescription{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Corner, position)},
      VkVertexInputAttributeDescription{1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Corner, normal)}};
  std::array<VkDynamicState, 2> dynamics{VK_DYNAMIC_STATE_CULL_MODE, VK_DYNAMIC_STATE_FRONT_FACE};
  VkViewport viewport;
  VkRect2D scissor;
  VkPipelineColorBlendAttachmentState written{};
  VkPipelineVertexInputStateCreateInfo input{};
  VkPipelineInputAssemblyStateCreateInfo assembly{};
  VkPipelineViewportStateCreateInfo viewports{};
  VkPipelineRasterizationStateCreateInfo raster{};
  VkPipelineMultisampleStateCreateInfo samples{};
  VkPipelineDepthStencilStateCreateInfo depth{};
  VkPipelineColorBlendStateCreateInfo blend{};
  VkPipelineDynamicStateCreateInfo dynamic{};
  VkPipelineRenderingCreateInfo rendering{};
};

VkRenderingAttachmentInfo cleared_attachment(VkImageView view, VkImageLayout layout) {
  VkRenderingAttachmentInfo info{};
  info.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
  info.imageView = view;
  info.imageLayout = layout;
  info.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
  info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  return info;
}

}  // namespace

ForeignRenderer::ForeignRenderer(const Scene& scene, Extent size, std::uint32_t layers)
    : scene_(scene), size_(size), layers_(layers) {
  make_instance();
  choose_device();
  make_device();
  depth_ = make_image(kDepth, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                      VK_IMAGE_ASPECT_DEPTH_BIT, 2);
  surfaces_ = make_image(kSurfaces, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                         VK_IMAGE_ASPECT_COLOR_BIT, 2);
  visibility_ =
      make_image(VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                 VK_IMAGE_ASPECT_COLOR_BIT, layers);
  read_ = make_buffer(layers * size.pixels() * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  make_pipeline();
  make_meshes();
}

ForeignRenderer::~ForeignRenderer() {
  vkDeviceWaitIdle(device_);
  for (const Buffer& buffer : buffers_) {
    vkDestroyBuffer(device_, buffer.buffer, nullptr);
    vkFreeMemory(device_, buffer.memory, nullptr);
  }
  for (const Image& image : images_made_) {
    for (VkImageView view : image.layers) vkDestroyImageView(device_, view, nullptr);
    vkDestroyImageView(device_, image.all, nullptr);
    vkDestroyImage(device_, image.image, nullptr);
    vkFreeMemory(device_, image.memory, nullptr);
  }
  vkDestroyPipeline(device_, pipeline_, nullptr);
  vkDestroyPipelineLayout(device_, layout_, nullptr);
  vkDestroyFence(device_, done_, nullptr);
  vkDestroyCommandPool(device_, pool_, nullptr);
  vkDestroyDevice(device_, nullptr);
  function_of<PFN_vkDestroyDebugUtilsMessengerEXT>(instance_, "vkDestroyDebugUtilsMessengerEXT")(
      instance_, messenger_, nullptr);
  vkDestroyInstance(instance_, nullptr);
}

void ForeignRenderer::make_instance() {
  const VkValidationFeatureEnableEXT synchronisation =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT checks{};
  checks.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
  checks.enabledValidationFeatureCount = 1;
  checks.pEnabledValidationFeatures = &synchronisation;
  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.apiVersion = VK_API_VERSION_1_3;
  const char* const layer = "VK_LAYER_KHRONOS_validation";
  const std::array extensions{VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  VkInstanceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pNext = &checks;
  info.pApplicationInfo = &application;
  info.enabledLayerCount = 1;
  info.ppEnabledLayerNames = &layer;
  info.enabledExtensionCount = narrow<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  must(vkCreateInstance(&info, nullptr, &instance_), "vkCreateInstance");
  VkDebugUtilsMessengerCreateInfoEXT messenger{};
  messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = keep_message;
  messenger.pUserData = &messages_;
  const auto make =
      function_of<PFN_vkCreateDebugUtilsMessengerEXT>(instance_, "vkCreateDebugUtilsMessengerEXT");
  must(make(instance_, &messenger, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT");
}

void ForeignRenderer::choose_device() {
  std::uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance_, &count, nullptr);
  std::vector<VkPhysicalDevice> devices(count);
  vkEnumeratePhysicalDevices(instance_, &count, devices.data());
  for (VkPhysicalDevice device : devices) {
    VkPhysicalDeviceProperties properties{};
    vkGetPhysicalDeviceProperties(device, &properties);
    if (std::string(properties.deviceName).find(test_gpu()) != std::string::npos) physical_ = device;
  }
  if (physical_ == nullptr) throw std::runtime_error("there is no device " + test_gpu());
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, families.data());
  constexpr VkQueueFlags kNeeded = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  while (queue_family_ < count && (families[queue_family_].queueFlags & kNeeded) != kNeeded) ++queue_family_;
}

void ForeignRenderer::make_device() {
  VkPhysicalDeviceVulkan13Features features13{};
  features13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
  features13.synchronization2 = features13.dynamicRendering = features13.maintenance4 = VK_TRUE;
  VkPhysicalDeviceVulkan12Features features12{};
  features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  features12.pNext = &features13;
  features12.shaderOutputLayer = VK_TRUE;
  const float priority = 1;
  VkDeviceQueueCreateInfo queue{};
  queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue.queueFamilyIndex = queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkDeviceCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  info.pNext = &features12;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  must(vkCreateDevice(physical_, &info, nullptr, &device_), "vkCreateDevice");
  vkGetDeviceQueue(device_, queue_family_, 0, &queue_);
  VkCommandPoolCreateInfo pool{};
  pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = queue_family_;
  must(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo buffers{};
  buffers.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  buffers.commandPool = pool_;
  buffers.commandBufferCount = 1;
  must(vkAllocateCommandBuffers(device_, &buffers, &commands_), "vkAllocateCommandBuffers");
  VkFenceCreateInfo fence{};
  fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
  must(vkCreateFence(device_, &fence, nullptr, &done_), "vkCreateFence");
}

VkDeviceMemory ForeignRenderer::allocate(const VkMemoryRequirements& needs,
                                         VkMemoryPropertyFlags properties) {
  VkPhysicalDeviceMemoryProperties memory{};
  vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
  std::uint32_t type = 0;
  while (type < memory.memoryTypeCount &&
         ((needs.memoryTypeBits >> type & 1u) == 0 ||
          (memory.memoryTypes[type].propertyFlags & properties) != properties))
    ++type;
  VkMemoryAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  info.allocationSize = needs.size;
  info.memoryTypeIndex = type;
  VkDeviceMemory result = nullptr;
  must(vkAllocateMemory(device_, &info, nullptr, &result), "vkAllocateMemory");
  return result;
}

ForeignRenderer::Buffer ForeignRenderer::make_buffer(std::size_t bytes, VkBufferUsageFlags usage) {
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = bytes;
  info.usage = usage;
  Buffer result;
  must(vkCreateBuffer(device_, &info, nullptr, &result.buffer), "vkCreateBuffer");
  VkMemoryRequirements needs{};
  vkGetBufferMemoryRequirements(device_, result.buffer, &needs);
  result.memory = allocate(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  must(vkBindBufferMemory(device_, result.buffer, result.memory, 0), "vkBindBufferMemory");
  must(vkMapMemory(device_, result.memory, 0, VK_WHOLE_SIZE, 0, &result.bytes), "vkMapMemory");
  buffers_.push_back(result);
  return result;
}

ForeignRenderer::Image ForeignRenderer::make_image(VkFormat format, VkImageUsageFlags usage,
                                                   VkImageAspectFlags aspect, std::uint32_t layers) {
  VkImageCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {size_.width, size_.height, 1};
  info.mipLevels = 1;
  info.arrayLayers = layers;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = usage;
  Image result;
  must(vkCreateImage(device_, &info, nullptr, &result.image), "vkCreateImage");
  VkMemoryRequirements needs{};
  vkGetImageMemoryRequirements(device_, result.image, &needs);
  result.memory = allocate(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  must(vkBindImageMemory(device_, result.image, result.memory, 0), "vkBindImageMemory");
  const auto view_of = [&](VkImageViewType type, std::uint32_t first, std::uint32_t count) {
    VkImageViewCreateInfo view{};
    view.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    view.image = result.image;
    view.viewType = type;
    view.format = format;
    view.subresourceRange = {aspect, 0, 1, first, count};
    VkImageView made = nullptr;
    must(vkCreateImageView(device_, &view, nullptr, &made), "vkCreateImageView");
    return made;
  };
  result.all = view_of(VK_IMAGE_VIEW_TYPE_2D_ARRAY, 0, layers);
  for (std::uint32_t layer = 0; layer < layers; ++layer)
    result.layers.push_back(view_of(VK_IMAGE_VIEW_TYPE_2D, layer, 1));
  images_made_.push_back(result);
  return result;
}

void ForeignRenderer::make_layout() {
  const VkPushConstantRange range{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                                  sizeof(Drawn)};
  VkPipelineLayoutCreateInfo layout{};
  layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  layout.pushConstantRangeCount = 1;
  layout.pPushConstantRanges = &range;
  must(vkCreatePipelineLayout(device_, &layout, nullptr, &layout_), "vkCreatePipelineLayout");
}

void ForeignRenderer::make_pipeline() {
  make_layout();
  const std::array shaders{make_shader(device_, foreign_vert_spv), make_shader(device_, foreign_frag_spv)};
  const std::array stages{stage_of(VK_SHADER_STAGE_VERTEX_BIT, shaders[0]),
                          stage_of(VK_SHADER_STAGE_FRAGMENT_BIT, shaders[1])};
  const FixedState fixed(size_);
  VkGraphicsPipelineCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
  info.pNext = &fixed.rendering;
  info.stageCount = narrow<std::uint32_t>(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &fixed.input;
  info.pInputAssemblyState = &fixed.assembly;
  info.pViewportState = &fixed.viewports;
  info.pRasterizationState = &fixed.raster;
  info.pMultisampleState = &fixed.samples;
  info.pDepthStencilState = &fixed.depth;
  info.pColorBlendState = &fixed.blend;
  info.pDynamicState = &fixed.dynamic;
  info.layout = layout_;
  must(vkCreateGraphicsPipelines(device_, nullptr, 1, &info, nullptr, &pipeline_),
       "vkCreateGraphicsPipelines");
  for (VkShaderModule shader : shaders) vkDestroyShaderModule(device_, shader, nullptr);
}

void ForeignRenderer::make_meshes() {
  for (const farshade::Mesh& mesh : scene_.meshes) {
    std::vector<Corner> corners;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
      corners.push_back({mesh.positions[i], mesh.normals[i]});
    Mesh made;
    made.count = narrow<std::uint32_t>(3 * mesh.triangles.size());
    made.vertices = make_buffer(corners.size() * sizeof(Corner), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    std::memcpy(made.vertices.bytes, corners.data(), corners.size() * sizeof(Corner));
    made.indices = make_buffer(made.count * sizeof(std::uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    std::memcpy(made.indices.bytes, mesh.triangles.data(), made.count * sizeof(std::uint32_t));
    meshes_.push_back(made);
  }
}

gpu::ForeignDevice ForeignRenderer::device() const {
  return {instance_, physical_, device_, queue_, queue_family_};
}

VisibilityImages ForeignRenderer::images() const {
  return {.depth = depth_.all, .surfaces = surfaces_.all, .visibility = visibility_.all};
}

VkCommandBuffer ForeignRenderer::begin() {
  VkCommandBufferBeginInfo info{};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  must(vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
  return commands_;
}

void ForeignRenderer::draw_instance(std::size_t i, std::size_t eye, const StereoView& views,
                                    const SceneState& state) {
  const Mesh& mesh = meshes_[scene_.instances[i].mesh];
  const gpu::InstanceData data = instance_data(views, state.stage_from_object[i]);
  const glm::vec4 window = window_data(views[eye]).origin_step;
  const glm::mat4& normals = data.stage_from_object_normal;
  const Drawn drawn{data.clip_from_object[eye],
                    {glm::vec4(glm::vec3(normals[0]), window.x), glm::vec4(glm::vec3(normals[1]), window.y),
                     glm::vec4(glm::vec3(normals[2]), window.z)},
                    window.w,
                    narrow<std::uint32_t>(i)};
  vkCmdPushConstants(commands_, layout_, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                     sizeof(Drawn), &drawn);
  const Material& material = scene_.materials[scene_.meshes[scene_.instances[i].mesh].material];
  const bool mirrored = glm::determinant(glm::dmat3(state.stage_from_object[i].matrix)) < 0;
  vkCmdSetCullMode(commands_, material.double_sided ? VK_CULL_MODE_NONE : VK_CULL_MODE_BACK_BIT);
  vkCmdSetFrontFace(commands_, mirrored ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
  const VkDeviceSize offset = 0;
  vkCmdBindVertexBuffers(commands_, 0, 1, &mesh.vertices.buffer, &offset);
  vkCmdBindIndexBuffer(commands_, mesh.indices.buffer, 0, VK_INDEX_TYPE_UINT32);
  vkCmdDrawIndexed(commands_, mesh.count, 1, 0, 0, 0);
}

void ForeignRenderer::draw_eye(std::size_t eye, const StereoView& views, const SceneState& state) {
  const VkRenderingAttachmentInfo color = cleared_attachment(surfaces_.layers[eye],
                                                             VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL),
                                  depth = cleared_attachment(depth_.layers[eye],
                                                             VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL);
  VkRenderingInfo info{};
  info.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
  info.renderArea = {{0, 0}, {size_.width, size_.height}};
  info.layerCount = 1;
  info.colorAttachmentCount = 1;
  info.pColorAttachments = &color;
  info.pDepthAttachment = &depth;
  vkCmdBeginRendering(commands_, &info);
  vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
  for (std::size_t i = 0; i < scene_.instances.size(); ++i) draw_instance(i, eye, views, state);
  vkCmdEndRendering(commands_);
}

void ForeignRenderer::draw(const StereoView& views, const SceneState& state) {
  const Side2 before{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_COPY_BIT, 0,
                     VK_IMAGE_LAYOUT_UNDEFINED};
  const Side2 read{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_READ_BIT,
                   VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const Side2 written{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_WRITE_BIT,
                      VK_IMAGE_LAYOUT_GENERAL};
  const Side2 colors{kDraws, kDrawn, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
      depths{kDraws, kDrawn, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL};
  record_barriers(commands_,
                  std::array{barrier_of(depth_.image, VK_IMAGE_ASPECT_DEPTH_BIT, before, depths),
                             barrier_of(surfaces_.image, VK_IMAGE_ASPECT_COLOR_BIT, before, colors)});
  for (std::size_t eye = 0; eye < kEyes; ++eye) draw_eye(eye, views, state);
  record_barriers(commands_,
                  std::array{barrier_of(depth_.image, VK_IMAGE_ASPECT_DEPTH_BIT, depths, read),
                             barrier_of(surfaces_.image, VK_IMAGE_ASPECT_COLOR_BIT, colors, read),
                             barrier_of(visibility_.image, VK_IMAGE_ASPECT_COLOR_BIT, before, written)});
}

void ForeignRenderer::read_back() {
  record_barriers(commands_,
                  std::array{barrier_of(visibility_.image, VK_IMAGE_ASPECT_COLOR_BIT,
                                        {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_WRITE_BIT,
                                         VK_IMAGE_LAYOUT_GENERAL},
                                        {VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                                         VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL})});
  VkBufferImageCopy copy{};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, layers_};
  copy.imageExtent = {size_.width, size_.height, 1};
  vkCmdCopyImageToBuffer(commands_, visibility_.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, read_.buffer, 1,
                         &copy);
  VkMemoryBarrier2 seen{};
  seen.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
  seen.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
  seen.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
  seen.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
  seen.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
  VkDependencyInfo info{};
  info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &seen;
  vkCmdPipelineBarrier2(commands_, &info);
}

void ForeignRenderer::end() {
  must(vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
  VkSubmitInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands_;
  must(vkQueueSubmit(queue_, 1, &info, done_), "vkQueueSubmit");
  must(vkWaitForFences(device_, 1, &done_, VK_TRUE, gpu::kGpuTimeout_ns), "vkWaitForFences");
  must(vkResetFences(device_, 1, &done_), "vkResetFences");
}

std::vector<std::uint8_t> ForeignRenderer::visibilities() const {
  const auto* const bytes = static_cast<const std::uint8_t*>(read_.bytes);
  return {bytes, bytes + layers_ * size_.pixels() * 4};
}

void ForeignRenderer::make_a_hazard() {
  static_cast<void>(begin());
  for (const std::uint32_t value : {1u, 2u}) vkCmdFillBuffer(commands_, read_.buffer, 0, 16, value);
  end();
}

}  // namespace farshade
