#include "vr_client/draw/gbuffer.h"

#include <algorithm>
#include <array>

#include "shaders/gbuffer.frag.spv.h"
#include "shaders/gbuffer.vert.spv.h"
#include "shaders/gbuffer_textured.frag.spv.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;
using Usage = vk::ImageUsageFlagBits;

constexpr vk::Format kColorFormat = vk::Format::eR8G8B8A8Srgb, kSurfaceFormat = vk::Format::eR32G32Uint,
                     kDepthFormat = vk::Format::eD32Sfloat;

gpu::Image make_layers(const gpu::Device& device, Extent size, std::uint32_t layers, vk::Format format,
                       vk::ImageUsageFlags usage, const std::string& name) {
  return gpu::make_image(
      device, {.size = size, .layers = layers, .format = format, .usage = usage | Usage::eSampled}, name);
}

vk::RenderingAttachmentInfo attachment(vk::ImageView view, vk::ImageLayout layout) {
  return {.imageView = view,
          .imageLayout = layout,
          .loadOp = vk::AttachmentLoadOp::eClear,
          .storeOp = vk::AttachmentStoreOp::eStore,
          .clearValue = {}};
}

}  // namespace

GBufferPass::GBufferPass(const gpu::Device& device, const Scene& scene, Extent size,
                         std::uint32_t depth_frames)
    : device_(device),
      scene_(scene),
      size_(size),
      buffers_(make_scene_buffers(device, scene)),
      instance_buffer_(gpu::make_mapped_buffer(device, scene.instances.size() * sizeof(gpu::InstanceData),
                                               vk::BufferUsageFlagBits::eStorageBuffer, "instances")),
      frame_buffer_(gpu::make_mapped_buffer(device, sizeof(gpu::FrameData),
                                            vk::BufferUsageFlagBits::eUniformBuffer, "frame")),
      base_colors_(make_layers(device, size, kEyes, kColorFormat, Usage::eColorAttachment, "base colours")),
      surfaces_(make_layers(device, size, kEyes, kSurfaceFormat, Usage::eColorAttachment, "surfaces")),
      depth_ring_(make_layers(device, size, kEyes * depth_frames, kDepthFormat,
                              Usage::eDepthStencilAttachment | Usage::eTransferSrc, "depth ring")),
      slots_(depth_frames),
      bindings_(gpu::make_bindings(device,
                                   {{vk::DescriptorType::eStorageBuffer, vk::ShaderStageFlagBits::eVertex},
                                    {vk::DescriptorType::eUniformBuffer, vk::ShaderStageFlagBits::eFragment}},
                                   "G-buffer")),
      vertex_shader_(gpu::make_shader(device, gbuffer_vert_spv, "gbuffer.vert")),
      plain_shader_(gpu::make_shader(device, gbuffer_frag_spv, "gbuffer.frag")),
      textured_shader_(gpu::make_shader(device, gbuffer_textured_frag_spv, "gbuffer.frag, textured")) {
  check(scene.instances.size() <= kMaxInstances, "the G-buffer can tell all instances apart");
  gpu::bind_buffer(device, bindings_, 0, instance_buffer_);
  gpu::bind_buffer(device, bindings_, 1, frame_buffer_);
  const std::array sets{*bindings_.layout, *buffers_.texture_layout};
  const vk::PushConstantRange push{vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0,
                                   sizeof(gpu::DrawData)};
  layout_ = device.logical.createPipelineLayout({.setLayoutCount = sets.size(),
                                                 .pSetLayouts = sets.data(),
                                                 .pushConstantRangeCount = 1,
                                                 .pPushConstantRanges = &push});
  for (const Mesh& mesh : scene.meshes)
    if (const Variant variant = variant_of(mesh); !pipelines_.contains(variant))
      pipelines_.emplace(variant, make_pipeline(variant));
  for (std::uint32_t i = 0; i < depth_frames; ++i)
    slots_[i].view = gpu::view_layers(device, depth_ring_, i * kEyes, kEyes);
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    for (const gpu::Image* image : {&base_colors_, &surfaces_, &depth_ring_})
      gpu::transition(commands, *image, Layout::eUndefined, Layout::eShaderReadOnlyOptimal);
  });
}

GBufferPass::Variant GBufferPass::variant_of(const Mesh& mesh) const {
  const Material& material = scene_.materials[mesh.material];
  return {material.texture && !mesh.uvs.empty(), material.alpha_cutoff.has_value(), !mesh.colors.empty()};
}

vk::raii::Pipeline GBufferPass::make_pipeline(Variant variant) const {
  const gpu::Specialization specialization({variant.textured, variant.masked, variant.colored});
  const vk::SpecializationInfo constants = specialization.info();
  const std::array stages{
      vk::PipelineShaderStageCreateInfo{.stage = vk::ShaderStageFlagBits::eVertex,
                                        .module = *vertex_shader_,
                                        .pName = "main",
                                        .pSpecializationInfo = &constants},
      vk::PipelineShaderStageCreateInfo{.stage = vk::ShaderStageFlagBits::eFragment,
                                        .module = *(variant.textured ? textured_shader_ : plain_shader_),
                                        .pName = "main",
                                        .pSpecializationInfo = &constants}};

  // Locations 0..3 are the streams positions, normals, uvs, colours, each its own buffer. A stream that this
  // variant does not read is bound to the positions and never fetched.
  const std::array formats{vk::Format::eR32G32B32Sfloat, vk::Format::eR32G32B32Sfloat,
                           vk::Format::eR32G32Sfloat, vk::Format::eR8G8B8A8Unorm};
  const std::array strides{sizeof(glm::vec3), sizeof(glm::vec3), sizeof(glm::vec2), sizeof(glm::u8vec4)};
  std::array<vk::VertexInputBindingDescription, 4> streams;
  std::array<vk::VertexInputAttributeDescription, 4> attributes;
  for (std::uint32_t i = 0; i < 4; ++i) {
    streams[i] = {i, narrow<std::uint32_t>(strides[i]), vk::VertexInputRate::eVertex};
    attributes[i] = {i, i, formats[i], 0};
  }
  const vk::PipelineVertexInputStateCreateInfo vertices{.vertexBindingDescriptionCount = streams.size(),
                                                        .pVertexBindingDescriptions = streams.data(),
                                                        .vertexAttributeDescriptionCount = attributes.size(),
                                                        .pVertexAttributeDescriptions = attributes.data()};
  const vk::PipelineInputAssemblyStateCreateInfo assembly{.topology = vk::PrimitiveTopology::eTriangleList};
  const vk::PipelineViewportStateCreateInfo viewports{.viewportCount = 1, .scissorCount = 1};
  const vk::PipelineRasterizationStateCreateInfo raster{.polygonMode = vk::PolygonMode::eFill,
                                                        .lineWidth = 1};
  const vk::PipelineMultisampleStateCreateInfo samples{.rasterizationSamples = vk::SampleCountFlagBits::e1};
  const vk::PipelineDepthStencilStateCreateInfo depth{
      .depthTestEnable = true, .depthWriteEnable = true, .depthCompareOp = vk::CompareOp::eGreater};
  using Component = vk::ColorComponentFlagBits;
  const vk::PipelineColorBlendAttachmentState write{.colorWriteMask = Component::eR | Component::eG |
                                                                      Component::eB | Component::eA};
  const std::array writes{write, write};
  const vk::PipelineColorBlendStateCreateInfo blend{.attachmentCount = writes.size(),
                                                    .pAttachments = writes.data()};
  const std::array dynamics{vk::DynamicState::eViewport, vk::DynamicState::eScissor,
                            vk::DynamicState::eCullMode, vk::DynamicState::eFrontFace};
  const vk::PipelineDynamicStateCreateInfo dynamic{.dynamicStateCount = dynamics.size(),
                                                   .pDynamicStates = dynamics.data()};
  const std::array formats_out{kColorFormat, kSurfaceFormat};
  const vk::PipelineRenderingCreateInfo rendering{.colorAttachmentCount = formats_out.size(),
                                                  .pColorAttachmentFormats = formats_out.data(),
                                                  .depthAttachmentFormat = kDepthFormat};
  auto pipeline = device_.logical.createGraphicsPipeline(nullptr, {.pNext = &rendering,
                                                                   .stageCount = stages.size(),
                                                                   .pStages = stages.data(),
                                                                   .pVertexInputState = &vertices,
                                                                   .pInputAssemblyState = &assembly,
                                                                   .pViewportState = &viewports,
                                                                   .pRasterizationState = &raster,
                                                                   .pMultisampleState = &samples,
                                                                   .pDepthStencilState = &depth,
                                                                   .pColorBlendState = &blend,
                                                                   .pDynamicState = &dynamic,
                                                                   .layout = *layout_});
  gpu::set_name(device_, pipeline, "G-buffer");
  return pipeline;
}

void GBufferPass::prepare(const StereoView& views, const SceneState& state) {
  const auto data = instance_buffer_.as<gpu::InstanceData>();
  draws_.clear();
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
    const MeshBuffers& mesh = buffers_.meshes[scene_.instances[i].mesh];
    data[i] = instance_data(views, state.stage_from_object[i]);
    const bool left = may_be_seen(data[i], 0, mesh.low, mesh.high),
               right = may_be_seen(data[i], 1, mesh.low, mesh.high);
    if (!left && !right) continue;
    const glm::vec4 centre = data[i].clip_from_object[0] * glm::vec4((mesh.low + mesh.high) * 0.5f, 1.0f);
    draws_.push_back({i, left ? 0u : 1u, left && right ? 2u : 1u, centre.w,
                      glm::determinant(glm::dmat3(state.stage_from_object[i].matrix)) < 0});
  }
  // Near ones first, so that the depth test spares shading.
  std::sort(draws_.begin(), draws_.end(),
            [](const Draw& a, const Draw& b) { return a.distance < b.distance; });
}

void GBufferPass::record(const vk::raii::CommandBuffer& commands, FrameId frame) {
  Slot& slot = slots_[slot_of(frame)];
  slot.frame = frame;
  const gpu::LayerRange layers{depth_layer(frame), kEyes};
  gpu::transition(commands, base_colors_, Layout::eUndefined, Layout::eColorAttachmentOptimal);
  gpu::transition(commands, surfaces_, Layout::eUndefined, Layout::eColorAttachmentOptimal);
  gpu::transition(commands, depth_ring_, Layout::eUndefined, Layout::eDepthAttachmentOptimal, layers);

  const std::array colors{attachment(*base_colors_.view, Layout::eColorAttachmentOptimal),
                          attachment(*surfaces_.view, Layout::eColorAttachmentOptimal)};
  const vk::RenderingAttachmentInfo depth = attachment(*slot.view, Layout::eDepthAttachmentOptimal);
  const vk::Rect2D area{.extent = {size_.width, size_.height}};
  commands.beginRendering({.renderArea = area,
                           .layerCount = kEyes,
                           .colorAttachmentCount = colors.size(),
                           .pColorAttachments = colors.data(),
                           .pDepthAttachment = &depth});
  commands.setViewport(0, vk::Viewport{.width = static_cast<float>(size_.width),
                                       .height = static_cast<float>(size_.height),
                                       .maxDepth = 1});
  commands.setScissor(0, area);
  commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout_, 0, *bindings_.set, {});
  for (const Draw& draw : draws_) {
    const Material& material = scene_.materials[scene_.meshes[scene_.instances[draw.instance].mesh].material];
    commands.setCullMode(material.double_sided ? vk::CullModeFlagBits::eNone : vk::CullModeFlagBits::eBack);
    commands.setFrontFace(draw.mirrored ? vk::FrontFace::eClockwise : vk::FrontFace::eCounterClockwise);
    draw_instance(commands, draw);
  }
  commands.endRendering();

  gpu::transition(commands, base_colors_, Layout::eColorAttachmentOptimal, Layout::eShaderReadOnlyOptimal);
  gpu::transition(commands, surfaces_, Layout::eColorAttachmentOptimal, Layout::eShaderReadOnlyOptimal);
  gpu::transition(commands, depth_ring_, Layout::eDepthAttachmentOptimal, Layout::eShaderReadOnlyOptimal,
                  layers);
}

void GBufferPass::draw_instance(const vk::raii::CommandBuffer& commands, const Draw& draw) const {
  const std::uint32_t mesh_index = scene_.instances[draw.instance].mesh;
  const Mesh& mesh = scene_.meshes[mesh_index];
  const Material& material = scene_.materials[mesh.material];
  const MeshBuffers& buffers = buffers_.meshes[mesh_index];
  const Variant variant = variant_of(mesh);
  commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipelines_.at(variant));
  if (variant.textured)
    commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout_, 1,
                                *buffers_.textures[*material.texture].bindings.set, {});
  const vk::Buffer positions = *buffers.positions.buffer;
  commands.bindVertexBuffers(
      0,
      {positions, *buffers.normals.buffer, variant.textured ? *buffers.uvs.buffer : positions,
       variant.colored ? *buffers.colors.buffer : positions},
      {0, 0, 0, 0});
  commands.bindIndexBuffer(*buffers.indices.buffer, 0, vk::IndexType::eUint32);
  const gpu::DrawData data{material.base_color, draw.instance, material.alpha_cutoff.value_or(0.0f)};
  commands.pushConstants<gpu::DrawData>(
      *layout_, vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0, data);
  commands.drawIndexed(buffers.index_count, draw.eyes, 0, 0, draw.first_eye);
}

bool GBufferPass::has_depth(FrameId frame) const {
  return slots_[slot_of(frame)].frame == frame;
}

std::uint32_t GBufferPass::depth_layer(FrameId frame) const {
  return static_cast<std::uint32_t>(slot_of(frame) * kEyes);
}

}  // namespace farshade
