#include "stereo/draw/scene_pass.h"

#include <algorithm>
#include <array>
#include <set>

#include "stereo/detail/level_choice.h"

namespace farshade {
namespace {

/// Set 0 of gbuffer.vert and gbuffer.frag.
std::vector<gpu::BindingKind> scene_set(Outputs outputs) {
  std::vector<gpu::BindingKind> kinds{{vk::DescriptorType::eStorageBuffer, vk::ShaderStageFlagBits::eVertex}};
  if (outputs == Outputs::GBuffer)
    kinds.push_back({vk::DescriptorType::eUniformBuffer, vk::ShaderStageFlagBits::eFragment});
  return kinds;
}

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
      bindings_(gpu::make_bindings(device, scene_set(outputs), to_string(outputs))),
      draws_(pairs),
      last_levels_(pairs * scene.instances.size(), 0) {
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
  if (!plan.builds_late) make_all_pipelines();
}

void ScenePass::make_all_pipelines() {
  for (std::size_t mesh = 0; mesh < scene_.meshes.size(); ++mesh) need_pipeline(variant_of(mesh));
}

void ScenePass::prepare_warm_up() {
  make_all_pipelines();
  std::ranges::fill(instances_.as<gpu::InstanceData>(), gpu::InstanceData{});  // every corner at w = 0
  draws_[0].clear();
  std::set<SceneVariant> drawn;
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i)
    if (drawn.insert(variant_of(scene_.instances[i].mesh)).second)
      draws_[0].push_back({.instance = i, .data = i, .first_eye = 0, .eyes = 2});
}

SceneVariant ScenePass::variant_of(std::size_t mesh) const {
  return variant_for(plan_.surfaces[mesh], outputs_);
}

void ScenePass::need_pipeline(SceneVariant variant) {
  if (!pipelines_.contains(variant))
    pipelines_.emplace(variant, make_scene_pipeline(device_, layout_, plan_, outputs_, variant));
}

/// Bytes that drawing a level of a mesh for one eye reads.
std::uint64_t ScenePass::bytes_read(std::size_t mesh, std::uint32_t level) const {
  const StreamBytes& bytes = buffers_.meshes[mesh].bytes;
  const SceneVariant variant = variant_of(mesh);
  const std::uint64_t streams = bytes.positions + (outputs_ == Outputs::GBuffer ? bytes.normals : 0) +
                                (variant.textured ? bytes.uvs : 0) + (variant.colored ? bytes.colors : 0);
  const IndexRange& range = buffers_.meshes[mesh].ranges[level];
  const std::size_t vertices = scene_.meshes[mesh].positions.size();
  return streams / std::max(vertices, std::size_t{1}) * range.vertices + range.count * index_bytes(vertices);
}

void ScenePass::clear_counts() {
  vertex_bytes_read_ = triangles_ = 0;
}

void ScenePass::prepare(const StereoView& views, const SceneState& state, Detail detail) {
  clear_counts();
  add_draws(0, state, {views[0].size, views[1].size}, detail,
            [&](const Affine<Stage, Object>& stage_from_object) {
              return instance_data(views, stage_from_object);
            });
}

void ScenePass::prepare(std::span<const PerEye<glm::dmat4>> clip_from_stage, Extent size,
                        const SceneState& state) {
  check(outputs_ != Outputs::GBuffer, "normals are seen by eyes");
  check_eq(clip_from_stage.size(), draws_.size(), "views for each pair of layers");
  clear_counts();
  for (std::size_t pair = 0; pair < draws_.size(); ++pair)
    add_draws(pair, state, {size, size}, Detail::Levels, [&](const Affine<Stage, Object>& stage_from_object) {
      gpu::InstanceData data{};
      for (std::size_t layer = 0; layer < kEyes; ++layer)
        data.clip_from_object[layer] = glm::mat4(clip_from_stage[pair][layer] * stage_from_object.matrix);
      return data;
    });
}

/// The level for the view that shows the instance's error largest. `last` is the choice of the last frame.
std::uint32_t ScenePass::level_for(const DeviceMesh& mesh, const gpu::InstanceData& data,
                                   const PerEye<Extent>& sizes, std::uint32_t& last) const {
  if (mesh.levels.empty() || plan_.detail_px <= 0) return 0;
  double px_per_unit = 0;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    if (may_be_seen(data, eye, mesh.box))
      px_per_unit = std::max(px_per_unit,
                             pixels_per_unit(glm::dmat4(data.clip_from_object[eye]), mesh.box, sizes[eye]));
  last = choose_level(mesh.levels, px_per_unit, plan_.detail_px, last);
  return last;
}

template <class SeenAs>
void ScenePass::add_draws(std::size_t pair, const SceneState& state, const PerEye<Extent>& sizes,
                          Detail detail, const SeenAs& seen_as) {
  const auto first = narrow<std::uint32_t>(pair * scene_.instances.size());
  const auto data = instances_.as<gpu::InstanceData>().subspan(first);
  std::vector<Draw>& draws = draws_[pair];
  draws.clear();
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
    const std::uint32_t mesh_index = scene_.instances[i].mesh;
    const DeviceMesh& mesh = buffers_.meshes[mesh_index];
    Affine<Stage, Object> stage_from_mesh = state.stage_from_object[i];
    stage_from_mesh.matrix[3] = glm::dvec4(stage_from_mesh(Point<Object>{mesh.center}).v, 1.0);
    data[i] = seen_as(stage_from_mesh);
    const bool left = may_be_seen(data[i], 0, mesh.box), right = may_be_seen(data[i], 1, mesh.box);
    if (!left && !right) continue;
    const glm::vec3 middle = (glm::vec3(mesh.box.low) + glm::vec3(mesh.box.high)) * 0.5f;
    const glm::vec4 centre = data[i].clip_from_object[0] * glm::vec4(middle, 1.0f);
    const std::uint32_t eyes = left && right ? 2 : 1;
    const std::uint32_t level =
        detail == Detail::Full ? 0 : level_for(mesh, data[i], sizes, last_levels_[first + i]);
    draws.push_back({i, first + i, left ? 0u : 1u, eyes, centre.w,
                     glm::determinant(glm::dmat3(state.stage_from_object[i].matrix)) < 0, level});
    need_pipeline(variant_of(mesh_index));
    vertex_bytes_read_ += bytes_read(mesh_index, level) * eyes;
    triangles_ += std::uint64_t{mesh.ranges[level].count / 3} * eyes;
  }
  // Nearest first, so that the depth test rejects most hidden pixels before shading.
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
  const Material& material = scene_.materials[scene_.meshes[mesh_index].material];
  const DeviceMesh& mesh = buffers_.meshes[mesh_index];
  const SceneVariant variant = variant_of(mesh_index);
  commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipelines_.at(variant));
  if (variant.textured)
    commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout_, 1,
                                *buffers_.texture_sets[*mesh.texture].set, {});
  std::array<vk::Buffer, 4> streams;
  streams.fill(*buffers_.vertices.buffer);
  std::array<vk::DeviceSize, 4> offsets{mesh.offsets.positions};
  std::uint32_t count = 1;
  if (outputs_ == Outputs::GBuffer) offsets[count++] = mesh.offsets.normals;
  if (variant.textured) offsets[count++] = mesh.offsets.uvs;
  if (variant.colored) offsets[count++] = mesh.offsets.colors;
  commands.bindVertexBuffers(0, vk::ArrayProxy(count, streams.data()), vk::ArrayProxy(count, offsets.data()));
  const gpu::DrawData data{material.base_color, draw.data, material.alpha_cutoff.value_or(0.0f)};
  commands.pushConstants<gpu::DrawData>(
      *layout_, vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment, 0, data);
  const IndexRange& range = mesh.ranges[draw.level];
  commands.bindIndexBuffer(*buffers_.indices.buffer, mesh.offsets.indices, mesh.index_type);
  commands.drawIndexed(range.count, draw.eyes, range.first, 0, draw.first_eye);
}

}  // namespace farshade
