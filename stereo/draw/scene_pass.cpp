#include "stereo/draw/scene_pass.h"

#include <algorithm>
#include <array>

#include "shaders/depth.frag.spv.h"
#include "shaders/depth.vert.spv.h"
#include "shaders/depth_color.frag.spv.h"
#include "shaders/depth_color.vert.spv.h"
#include "shaders/depth_uv.frag.spv.h"
#include "shaders/depth_uv.vert.spv.h"
#include "shaders/depth_uv_color.frag.spv.h"
#include "shaders/depth_uv_color.vert.spv.h"
#include "shaders/gbuffer.frag.spv.h"
#include "shaders/gbuffer.vert.spv.h"
#include "shaders/gbuffer_color.frag.spv.h"
#include "shaders/gbuffer_color.vert.spv.h"
#include "shaders/gbuffer_uv.frag.spv.h"
#include "shaders/gbuffer_uv.vert.spv.h"
#include "shaders/gbuffer_uv_color.frag.spv.h"
#include "shaders/gbuffer_uv_color.vert.spv.h"

namespace farshade {
namespace {

using Words = std::span<const std::uint32_t>;
struct Shaders {
  Words vertex, fragment;
};

const char* name_of(Outputs outputs) {
  switch (outputs) {
    case Outputs::Depth:
      return "depth";
    case Outputs::Casters:
      return "casters";
    default:
      return "G-buffer";
  }
}

Shaders shaders_of(Outputs outputs, bool textured, bool colored) {
  const std::array gbuffer{Shaders{gbuffer_vert_spv, gbuffer_frag_spv},
                           Shaders{gbuffer_uv_vert_spv, gbuffer_uv_frag_spv},
                           Shaders{gbuffer_color_vert_spv, gbuffer_color_frag_spv},
                           Shaders{gbuffer_uv_color_vert_spv, gbuffer_uv_color_frag_spv}};
  const std::array depth{Shaders{depth_vert_spv, depth_frag_spv},
                         Shaders{depth_uv_vert_spv, depth_uv_frag_spv},
                         Shaders{depth_color_vert_spv, depth_color_frag_spv},
                         Shaders{depth_uv_color_vert_spv, depth_uv_color_frag_spv}};
  const std::size_t streams = (textured ? 1u : 0u) + (colored ? 2u : 0u);
  return outputs == Outputs::GBuffer ? gbuffer[streams] : depth[streams];
}

/// Where the instances are, and for geometric normals the frame's windows.
std::vector<gpu::BindingKind> scene_set(Outputs outputs) {
  std::vector<gpu::BindingKind> kinds{{vk::DescriptorType::eStorageBuffer, vk::ShaderStageFlagBits::eVertex}};
  if (outputs == Outputs::GBuffer)
    kinds.push_back({vk::DescriptorType::eUniformBuffer, vk::ShaderStageFlagBits::eFragment});
  return kinds;
}

/// The streams that a pipeline reads, each its own buffer, bound one after the other.
class Streams {
 public:
  void add(std::uint32_t location, vk::Format format, std::uint32_t stride) {
    bindings_[count_] = {count_, stride, vk::VertexInputRate::eVertex};
    attributes_[count_] = {location, count_, format, 0};
    ++count_;
  }
  [[nodiscard]] vk::PipelineVertexInputStateCreateInfo info() const {
    return {.vertexBindingDescriptionCount = count_,
            .pVertexBindingDescriptions = bindings_.data(),
            .vertexAttributeDescriptionCount = count_,
            .pVertexAttributeDescriptions = attributes_.data()};
  }

 private:
  std::array<vk::VertexInputBindingDescription, 4> bindings_;
  std::array<vk::VertexInputAttributeDescription, 4> attributes_;
  std::uint32_t count_ = 0;
};

}  // namespace

vk::RenderingAttachmentInfo cleared(vk::ImageView view, vk::ImageLayout layout) {
  return {.imageView = view,
          .imageLayout = layout,
          .loadOp = vk::AttachmentLoadOp::eClear,
          .storeOp = vk::AttachmentStoreOp::eStore,
          .clearValue = {}};
}

ScenePass::ScenePass(const gpu::Device& device, const Scene& scene, const DrawPlan& plan,
                     const SceneBuffers& buffers, const gpu::Buffer& frame, Outputs outputs,
                     std::size_t pairs)
    : device_(device),
      scene_(scene),
      plan_(plan),
      buffers_(buffers),
      outputs_(outputs),
      instances_(gpu::make_mapped_buffer(device, pairs * scene.instances.size() * sizeof(gpu::InstanceData),
                                         vk::BufferUsageFlagBits::eStorageBuffer, "instances",
                                         gpu::Use::Frame)),
      bindings_(gpu::make_bindings(device, scene_set(outputs), name_of(outputs))),
      draws_(pairs) {
  gpu::bind_buffer(device, bindings_, 0, instances_);
  if (outputs == Outputs::GBuffer) gpu::bind_buffer(device, bindings_, 1, frame);
  std::vector<vk::DescriptorSetLayout> sets{*bindings_.layout};
  bool textured = false;
  for (std::size_t mesh = 0; mesh < scene.meshes.size(); ++mesh) textured |= variant_of(mesh).textured;
  if (textured) sets.push_back(*buffers_.texture_layout);
  const vk::PushConstantRange push{vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0,
                                   sizeof(gpu::DrawData)};
  layout_ = device.logical.createPipelineLayout({.setLayoutCount = narrow<std::uint32_t>(sets.size()),
                                                 .pSetLayouts = sets.data(),
                                                 .pushConstantRangeCount = 1,
                                                 .pPushConstantRanges = &push});
  for (std::size_t mesh = 0; mesh < scene.meshes.size() && !plan.builds_late; ++mesh)
    need_pipeline(variant_of(mesh));
}

ScenePass::Variant ScenePass::variant_of(std::size_t mesh) const {
  const SurfaceNeeds& needs = plan_.surfaces[mesh];
  const bool looked_at = needs.alpha_test || outputs_ == Outputs::GBuffer;
  return {looked_at && needs.texture, needs.alpha_test, looked_at && needs.vertex_color};
}

void ScenePass::need_pipeline(Variant variant) {
  if (!pipelines_.contains(variant)) pipelines_.emplace(variant, make_pipeline(variant));
}

/// One eye's draw of a mesh.
std::uint64_t ScenePass::bytes_read(std::size_t mesh) const {
  const StreamBytes& bytes = buffers_.meshes[mesh].bytes;
  const Variant variant = variant_of(mesh);
  return bytes.positions + bytes.indices + (outputs_ == Outputs::GBuffer ? bytes.normals : 0) +
         (variant.textured ? bytes.uvs : 0) + (variant.colored ? bytes.colors : 0);
}

vk::raii::Pipeline ScenePass::make_pipeline(Variant variant) const {
  const Shaders shaders = shaders_of(outputs_, variant.textured, variant.colored);
  const vk::raii::ShaderModule vertex = gpu::make_shader(device_, shaders.vertex, name_of(outputs_)),
                               fragment = gpu::make_shader(device_, shaders.fragment, name_of(outputs_));
  const bool some_move = std::ranges::find(plan_.moves, true) != plan_.moves.end();
  const gpu::Specialization specialization(
      {variant.masked, carries_masks(plan_), carries_masks(plan_) && some_move});
  const vk::SpecializationInfo constants = specialization.info();
  const std::array stages{vk::PipelineShaderStageCreateInfo{
                              .stage = vk::ShaderStageFlagBits::eVertex, .module = *vertex, .pName = "main"},
                          vk::PipelineShaderStageCreateInfo{.stage = vk::ShaderStageFlagBits::eFragment,
                                                            .module = *fragment,
                                                            .pName = "main",
                                                            .pSpecializationInfo = &constants}};
  Streams streams;
  streams.add(0, vk::Format::eR32G32B32Sfloat, sizeof(glm::vec3));
  if (outputs_ == Outputs::GBuffer) streams.add(1, vk::Format::eR32G32B32Sfloat, sizeof(glm::vec3));
  if (variant.textured) streams.add(2, vk::Format::eR32G32Sfloat, sizeof(glm::vec2));
  if (variant.colored) streams.add(3, vk::Format::eR8G8B8A8Unorm, sizeof(glm::u8vec4));
  const vk::PipelineVertexInputStateCreateInfo vertices = streams.info();
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
  const std::array formats_out{kColorFormat, surface_format(plan_)};
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
  gpu::set_name(device_, pipeline, name_of(outputs_));
  return pipeline;
}

void ScenePass::prepare(const StereoView& views, const SceneState& state) {
  vertex_bytes_read_ = 0;
  add_draws(0, state, [&](const Affine<Stage, Object>& stage_from_object) {
    return instance_data(views, stage_from_object);
  });
}

void ScenePass::prepare(std::span<const PerEye<glm::dmat4>> clip_from_stage, const SceneState& state) {
  check(outputs_ != Outputs::GBuffer, "normals are seen by eyes");
  check_eq(clip_from_stage.size(), draws_.size(), "views for each pair of layers");
  vertex_bytes_read_ = 0;
  for (std::size_t pair = 0; pair < draws_.size(); ++pair)
    add_draws(pair, state, [&](const Affine<Stage, Object>& stage_from_object) {
      gpu::InstanceData data{};
      for (std::size_t layer = 0; layer < kEyes; ++layer)
        data.clip_from_object[layer] = glm::mat4(clip_from_stage[pair][layer] * stage_from_object.matrix);
      return data;
    });
}

template <class SeenAs>
void ScenePass::add_draws(std::size_t pair, const SceneState& state, const SeenAs& seen_as) {
  const auto first = narrow<std::uint32_t>(pair * scene_.instances.size());
  const auto data = instances_.as<gpu::InstanceData>().subspan(first);
  std::vector<Draw>& draws = draws_[pair];
  draws.clear();
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
    const MeshBuffers& mesh = buffers_.meshes[scene_.instances[i].mesh];
    Affine<Stage, Object> stage_from_mesh = state.stage_from_object[i];
    stage_from_mesh.matrix[3] = glm::dvec4(stage_from_mesh(Point<Object>{mesh.center}).v, 1.0);
    data[i] = seen_as(stage_from_mesh);
    const bool left = may_be_seen(data[i], 0, mesh.low, mesh.high),
               right = may_be_seen(data[i], 1, mesh.low, mesh.high);
    if (!left && !right) continue;
    const glm::vec4 centre = data[i].clip_from_object[0] * glm::vec4((mesh.low + mesh.high) * 0.5f, 1.0f);
    draws.push_back({i, first + i, left ? 0u : 1u, left && right ? 2u : 1u, centre.w,
                     glm::determinant(glm::dmat3(state.stage_from_object[i].matrix)) < 0});
    need_pipeline(variant_of(scene_.instances[i].mesh));
    vertex_bytes_read_ += bytes_read(scene_.instances[i].mesh) * draws.back().eyes;
  }
  // Near ones first, so that the depth test spares shading.
  std::sort(draws.begin(), draws.end(), [](const Draw& a, const Draw& b) { return a.distance < b.distance; });
}

void ScenePass::record(const vk::raii::CommandBuffer& commands, Extent size,
                       std::span<const vk::RenderingAttachmentInfo> colors,
                       const vk::RenderingAttachmentInfo& depth, std::size_t pair) const {
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
  for (const Draw& draw : draws_[pair]) {
    const Material& material = scene_.materials[scene_.meshes[scene_.instances[draw.instance].mesh].material];
    const bool both_sides = material.double_sided || outputs_ == Outputs::Casters;
    commands.setCullMode(both_sides ? vk::CullModeFlagBits::eNone : vk::CullModeFlagBits::eBack);
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
  const Variant variant = variant_of(mesh_index);
  commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipelines_.at(variant));
  if (variant.textured)
    commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout_, 1,
                                *buffers_.textures[*buffers.texture].bindings.set, {});
  std::array<vk::Buffer, 4> streams{*buffers.positions.buffer};
  constexpr std::array<vk::DeviceSize, 4> from_the_start{};
  std::uint32_t count = 1;
  if (outputs_ == Outputs::GBuffer) streams[count++] = *buffers.normals.buffer;
  if (variant.textured) streams[count++] = *buffers.uvs.buffer;
  if (variant.colored) streams[count++] = *buffers.colors.buffer;
  commands.bindVertexBuffers(0, vk::ArrayProxy(count, streams.data()),
                             vk::ArrayProxy(count, from_the_start.data()));
  commands.bindIndexBuffer(*buffers.indices.buffer, 0, vk::IndexType::eUint32);
  const gpu::DrawData data{material.base_color, draw.data, material.alpha_cutoff.value_or(0.0f)};
  commands.pushConstants<gpu::DrawData>(
      *layout_, vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0, data);
  commands.drawIndexed(buffers.index_count, draw.eyes, 0, 0, draw.first_eye);
}

}  // namespace farshade
