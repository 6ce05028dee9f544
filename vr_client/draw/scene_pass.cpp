#include "vr_client/draw/scene_pass.h"

#include <algorithm>
#include <array>

#include "shaders/depth.frag.spv.h"
#include "shaders/depth.vert.spv.h"
#include "shaders/depth_textured.frag.spv.h"
#include "shaders/gbuffer.frag.spv.h"
#include "shaders/gbuffer.vert.spv.h"
#include "shaders/gbuffer_textured.frag.spv.h"

namespace farshade {
namespace {

struct Shaders {
  std::span<const std::uint32_t> vertex, plain, textured;
  const char* name;
};

Shaders shaders_of(Outputs outputs) {
  if (outputs == Outputs::Depth) return {depth_vert_spv, depth_frag_spv, depth_textured_frag_spv, "depth"};
  return {gbuffer_vert_spv, gbuffer_frag_spv, gbuffer_textured_frag_spv, "G-buffer"};
}

}  // namespace

vk::RenderingAttachmentInfo cleared(vk::ImageView view, vk::ImageLayout layout) {
  return {.imageView = view,
          .imageLayout = layout,
          .loadOp = vk::AttachmentLoadOp::eClear,
          .storeOp = vk::AttachmentStoreOp::eStore,
          .clearValue = {}};
}

ScenePass::ScenePass(const gpu::Device& device, const Scene& scene, const SceneBuffers& buffers,
                     const gpu::Buffer& frame, Outputs outputs)
    : device_(device),
      scene_(scene),
      buffers_(buffers),
      outputs_(outputs),
      instances_(gpu::make_mapped_buffer(device, scene.instances.size() * sizeof(gpu::InstanceData),
                                         vk::BufferUsageFlagBits::eStorageBuffer, "instances")),
      bindings_(gpu::make_bindings(device,
                                   {{vk::DescriptorType::eStorageBuffer, vk::ShaderStageFlagBits::eVertex},
                                    {vk::DescriptorType::eUniformBuffer, vk::ShaderStageFlagBits::eFragment}},
                                   shaders_of(outputs).name)),
      vertex_shader_(gpu::make_shader(device, shaders_of(outputs).vertex, shaders_of(outputs).name)),
      plain_shader_(gpu::make_shader(device, shaders_of(outputs).plain, shaders_of(outputs).name)),
      textured_shader_(gpu::make_shader(device, shaders_of(outputs).textured, shaders_of(outputs).name)) {
  gpu::bind_buffer(device, bindings_, 0, instances_);
  gpu::bind_buffer(device, bindings_, 1, frame);
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
}

ScenePass::Variant ScenePass::variant_of(const Mesh& mesh) const {
  const Material& material = scene_.materials[mesh.material];
  const bool masked = material.alpha_cutoff.has_value(), looked_at = masked || outputs_ == Outputs::GBuffer;
  return {looked_at && material.texture && !mesh.uvs.empty(), masked, looked_at && !mesh.colors.empty()};
}

vk::raii::Pipeline ScenePass::make_pipeline(Variant variant) const {
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
  const std::uint32_t color_count = outputs_ == Outputs::GBuffer ? 2 : 0;
  const vk::PipelineColorBlendStateCreateInfo blend{.attachmentCount = color_count,
                                                    .pAttachments = writes.data()};
  const std::array dynamics{vk::DynamicState::eViewport, vk::DynamicState::eScissor,
                            vk::DynamicState::eCullMode, vk::DynamicState::eFrontFace};
  const vk::PipelineDynamicStateCreateInfo dynamic{.dynamicStateCount = dynamics.size(),
                                                   .pDynamicStates = dynamics.data()};
  const std::array formats_out{kColorFormat, kSurfaceFormat};
  const vk::PipelineRenderingCreateInfo rendering{.colorAttachmentCount = color_count,
                                                  .pColorAttachmentFormats = formats_out.data(),
                                                  .depthAttachmentFormat = kDepthFormat};
  // Depth alone needs no fragment shader, unless it cuts holes.
  const std::uint32_t stage_count = outputs_ == Outputs::GBuffer || variant.masked ? 2 : 1;
  auto pipeline = device_.logical.createGraphicsPipeline(nullptr, {.pNext = &rendering,
                                                                   .stageCount = stage_count,
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
  gpu::set_name(device_, pipeline, shaders_of(outputs_).name);
  return pipeline;
}

void ScenePass::prepare(const StereoView& views, const SceneState& state) {
  const auto data = instances_.as<gpu::InstanceData>();
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

void ScenePass::record(const vk::raii::CommandBuffer& commands, Extent size,
                       std::span<const vk::RenderingAttachmentInfo> colors,
                       const vk::RenderingAttachmentInfo& depth) const {
  const vk::Rect2D area{.extent = {size.width, size.height}};
  commands.beginRendering({.renderArea = area,
                           .layerCount = kEyes,
                           .colorAttachmentCount = narrow<std::uint32_t>(colors.size()),
                           .pColorAttachments = colors.data(),
                           .pDepthAttachment = &depth});
  commands.setViewport(0, vk::Viewport{.width = static_cast<float>(size.width),
                                       .height = static_cast<float>(size.height),
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
}

void ScenePass::draw_instance(const vk::raii::CommandBuffer& commands, const Draw& draw) const {
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

}  // namespace farshade
