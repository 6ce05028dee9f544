#include "stereo/gpu/pass.h"

#include <optional>

namespace farshade::gpu {

vk::raii::DescriptorSetLayout make_layout(const Device& device, std::span<const BindingKind> kinds) {
  std::vector<vk::DescriptorSetLayoutBinding> slots;
  for (const BindingKind& kind : kinds)
    slots.push_back({.binding = narrow<std::uint32_t>(slots.size()),
                     .descriptorType = kind.type,
                     .descriptorCount = kind.count,
                     .stageFlags = kind.stages});
  return device.logical.createDescriptorSetLayout(
      {.bindingCount = narrow<std::uint32_t>(slots.size()), .pBindings = slots.data()});
}

Bindings make_bindings(const Device& device, std::vector<BindingKind> kinds, const std::string& name) {
  std::vector<vk::DescriptorPoolSize> sizes;
  for (const BindingKind& kind : kinds) sizes.push_back({.type = kind.type, .descriptorCount = kind.count});
  Bindings result;
  result.layout = make_layout(device, kinds);
  result.pool =
      device.logical.createDescriptorPool({.flags = vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                           .maxSets = 1,
                                           .poolSizeCount = narrow<std::uint32_t>(sizes.size()),
                                           .pPoolSizes = sizes.data()});
  const vk::DescriptorSetLayout layout = *result.layout;
  result.set = std::move(device.logical.allocateDescriptorSets(
      {.descriptorPool = *result.pool, .descriptorSetCount = 1, .pSetLayouts = &layout})[0]);
  result.kinds = std::move(kinds);
  set_name(device, result.set, name);
  return result;
}

void bind_buffer(const Device& device, const Bindings& bindings, std::uint32_t binding, const Buffer& buffer,
                 std::uint64_t range) {
  const vk::DescriptorBufferInfo info{.buffer = *buffer.buffer, .range = range};
  device.logical.updateDescriptorSets(vk::WriteDescriptorSet{.dstSet = *bindings.set,
                                                             .dstBinding = binding,
                                                             .descriptorCount = 1,
                                                             .descriptorType = bindings.kinds[binding].type,
                                                             .pBufferInfo = &info},
                                      {});
}

vk::raii::BufferView view_texels(const Device& device, const Buffer& buffer, vk::Format format) {
  return device.logical.createBufferView(
      {.buffer = *buffer.buffer, .format = format, .range = VK_WHOLE_SIZE});
}

void bind_texels(const Device& device, const Bindings& bindings, std::uint32_t binding, vk::BufferView view) {
  device.logical.updateDescriptorSets(vk::WriteDescriptorSet{.dstSet = *bindings.set,
                                                             .dstBinding = binding,
                                                             .descriptorCount = 1,
                                                             .descriptorType = bindings.kinds[binding].type,
                                                             .pTexelBufferView = &view},
                                      {});
}

void bind_image(const Device& device, const Bindings& bindings, std::uint32_t binding,
                const ImageBinding& image, std::uint32_t element) {
  const vk::DescriptorImageInfo info{
      .sampler = image.sampler, .imageView = image.view, .imageLayout = image.layout};
  device.logical.updateDescriptorSets(vk::WriteDescriptorSet{.dstSet = *bindings.set,
                                                             .dstBinding = binding,
                                                             .dstArrayElement = element,
                                                             .descriptorCount = 1,
                                                             .descriptorType = bindings.kinds[binding].type,
                                                             .pImageInfo = &info},
                                      {});
}

namespace {

/// A shader with its specialisation constants. The result of `stage` points into it.
class Shader {
 public:
  Shader(const Device& device, std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> constants,
         const std::string& name)
      : module_(device.logical.createShaderModule({.codeSize = spirv.size_bytes(), .pCode = spirv.data()})) {
    set_name(device, module_, name);
    for (std::uint32_t i = 0; i < constants.size(); ++i)
      entries_.push_back({.constantID = i, .offset = i * 4, .size = 4});
    constants_ = {.mapEntryCount = narrow<std::uint32_t>(entries_.size()),
                  .pMapEntries = entries_.data(),
                  .dataSize = constants.size_bytes(),
                  .pData = constants.data()};
  }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;
  [[nodiscard]] vk::PipelineShaderStageCreateInfo stage(vk::ShaderStageFlagBits stage) const {
    return {.stage = stage, .module = *module_, .pName = "main", .pSpecializationInfo = &constants_};
  }

 private:
  vk::raii::ShaderModule module_;
  std::vector<vk::SpecializationMapEntry> entries_;
  vk::SpecializationInfo constants_;
};

/// The streams of a pipeline as Vulkan describes them. `info` points into it.
struct VertexInput {
  explicit VertexInput(std::span<const VertexStream> streams) {
    for (const VertexStream& stream : streams) {
      const auto binding = narrow<std::uint32_t>(bindings.size());
      bindings.push_back({binding, stream.stride, vk::VertexInputRate::eVertex});
      attributes.push_back({stream.location, binding, stream.format, 0});
    }
  }
  [[nodiscard]] vk::PipelineVertexInputStateCreateInfo info() const {
    return {.vertexBindingDescriptionCount = narrow<std::uint32_t>(bindings.size()),
            .pVertexBindingDescriptions = bindings.data(),
            .vertexAttributeDescriptionCount = narrow<std::uint32_t>(attributes.size()),
            .pVertexAttributeDescriptions = attributes.data()};
  }

  std::vector<vk::VertexInputBindingDescription> bindings;
  std::vector<vk::VertexInputAttributeDescription> attributes;
};

constexpr vk::PipelineInputAssemblyStateCreateInfo kTriangles{.topology =
                                                                  vk::PrimitiveTopology::eTriangleList};
constexpr vk::PipelineViewportStateCreateInfo kOneViewport{.viewportCount = 1, .scissorCount = 1};
constexpr vk::PipelineRasterizationStateCreateInfo kFilled{.polygonMode = vk::PolygonMode::eFill,
                                                           .lineWidth = 1};
constexpr vk::PipelineMultisampleStateCreateInfo kOneSample{.rasterizationSamples =
                                                                vk::SampleCountFlagBits::e1};
constexpr vk::ColorComponentFlags kAllComponents =
    vk::ColorComponentFlagBits::eR | vk::ColorComponentFlagBits::eG | vk::ColorComponentFlagBits::eB |
    vk::ColorComponentFlagBits::eA;

}  // namespace

vk::raii::Pipeline make_compute_pipeline(const Device& device, const vk::raii::PipelineLayout& layout,
                                         std::span<const std::uint32_t> spirv,
                                         std::span<const std::uint32_t> constants, const std::string& name) {
  const Shader shader(device, spirv, constants, name);
  auto pipeline = device.logical.createComputePipeline(
      device.pipelines, {.stage = shader.stage(vk::ShaderStageFlagBits::eCompute), .layout = *layout});
  set_name(device, pipeline, name);
  return pipeline;
}

vk::raii::Pipeline make_graphics_pipeline(const Device& device, const vk::raii::PipelineLayout& layout,
                                          const GraphicsPipeline& wanted, const std::string& name) {
  const Shader vertex(device, wanted.vertex, {}, name);
  std::vector<vk::PipelineShaderStageCreateInfo> stages{vertex.stage(vk::ShaderStageFlagBits::eVertex)};
  std::optional<Shader> fragment;
  if (!wanted.fragment.empty()) {
    fragment.emplace(device, wanted.fragment, wanted.constants, name);
    stages.push_back(fragment->stage(vk::ShaderStageFlagBits::eFragment));
  }
  const VertexInput input(wanted.streams);
  const vk::PipelineVertexInputStateCreateInfo vertices = input.info();
  const bool has_depth = wanted.depth != vk::Format::eUndefined;
  const vk::PipelineDepthStencilStateCreateInfo depth{
      .depthTestEnable = has_depth, .depthWriteEnable = has_depth, .depthCompareOp = wanted.depth_test};
  const bool writes_colors = wanted.writes == GraphicsPipeline::Writes::Colors;
  const std::vector<vk::PipelineColorBlendAttachmentState> colors(
      wanted.colors.size(), {.colorWriteMask = writes_colors ? kAllComponents : vk::ColorComponentFlags{}});
  const auto color_count = narrow<std::uint32_t>(colors.size());
  const vk::PipelineColorBlendStateCreateInfo blend{.attachmentCount = color_count,
                                                    .pAttachments = colors.data()};
  const vk::PipelineRenderingCreateInfo rendering{.colorAttachmentCount = color_count,
                                                  .pColorAttachmentFormats = wanted.colors.data(),
                                                  .depthAttachmentFormat = wanted.depth};
  std::vector<vk::DynamicState> dynamics{vk::DynamicState::eViewport, vk::DynamicState::eScissor};
  dynamics.insert(dynamics.end(), wanted.dynamic.begin(), wanted.dynamic.end());
  const vk::PipelineDynamicStateCreateInfo dynamic{
      .dynamicStateCount = narrow<std::uint32_t>(dynamics.size()), .pDynamicStates = dynamics.data()};
  auto pipeline = device.logical.createGraphicsPipeline(device.pipelines,
                                                        {.pNext = &rendering,
                                                         .stageCount = narrow<std::uint32_t>(stages.size()),
                                                         .pStages = stages.data(),
                                                         .pVertexInputState = &vertices,
                                                         .pInputAssemblyState = &kTriangles,
                                                         .pViewportState = &kOneViewport,
                                                         .pRasterizationState = &kFilled,
                                                         .pMultisampleState = &kOneSample,
                                                         .pDepthStencilState = &depth,
                                                         .pColorBlendState = &blend,
                                                         .pDynamicState = &dynamic,
                                                         .layout = *layout});
  set_name(device, pipeline, name);
  return pipeline;
}

Timestamps::Timestamps(const Device& device, std::uint32_t count)
    : pool_(device.logical.createQueryPool({.queryType = vk::QueryType::eTimestamp, .queryCount = count})),
      bits_(device.timestamp_bits),
      period_ns_(device.timestamp_period_ns) {}

void Timestamps::reset(const vk::raii::CommandBuffer& commands, std::uint32_t first,
                       std::uint32_t count) const {
  commands.resetQueryPool(*pool_, first, count);
}

void Timestamps::write(const vk::raii::CommandBuffer& commands, std::uint32_t index) const {
  commands.writeTimestamp2(vk::PipelineStageFlagBits2::eAllCommands, *pool_, index);
}

Duration Timestamps::between(std::uint32_t from, std::uint32_t to) const {
  const std::uint32_t count = to - from + 1;
  const auto [result, ticks] =
      pool_.getResults<std::uint64_t>(from, count, count * sizeof(std::uint64_t), sizeof(std::uint64_t),
                                      vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait);
  check(result == vk::Result::eSuccess, "timestamps are available once the device has finished");
  return Duration(static_cast<std::int64_t>(
      static_cast<double>(ticks_between(ticks.front(), ticks.back(), bits_)) * period_ns_));
}

}  // namespace farshade::gpu
