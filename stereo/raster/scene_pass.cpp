#include "stereo/raster/scene_pass.h"

#include <algorithm>
#include <array>
#include <set>

#include "stereo/lod/level_choice.h"

namespace farshade {
namespace {

// Uniform blocks begin at multiples of minUniformBufferOffsetAlignment, which is at most 256.
static_assert(sizeof(gpu::InstanceData) % 256 == 0);

/// Set 0 of gbuffer.vert and gbuffer.frag.
std::vector<gpu::BindingKind> scene_set(Outputs outputs) {
  using Stage = vk::ShaderStageFlagBits;
  std::vector<gpu::BindingKind> kinds{
      {vk::DescriptorType::eUniformBufferDynamic, Stage::eVertex | Stage::eFragment}};
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

ScenePass::ScenePass(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
                     const SceneBuffers& buffers, const gpu::UploadBuffer& frame, Outputs outputs,
                     std::size_t pairs, std::shared_ptr<ScenePipelines> pipelines)
    : device_(frames.device()),
      scene_(scene),
      plan_(plan),
      buffers_(buffers),
      frame_(frame),
      outputs_(outputs),
      instances_(gpu::make_upload_buffer(frames, pairs * scene.instances.size() * sizeof(gpu::InstanceData),
                                         vk::BufferUsageFlagBits::eUniformBuffer, "instances",
                                         gpu::Use::Frame)),
      deformed_(&buffers.deformed->any()),
      bindings_(gpu::make_bindings(device_, scene_set(outputs), to_string(outputs))),
      pipelines_(std::move(pipelines)),
      draws_(pairs),
      last_levels_(scene.instances.size(), 0) {
  gpu::bind_buffer(device_, bindings_, 0, instances_.buffer(), sizeof(gpu::InstanceData));
  if (outputs == Outputs::GBuffer) gpu::bind_buffer(device_, bindings_, 1, frame.buffer());
  std::vector<vk::DescriptorSetLayout> sets{*bindings_.layout};
  bool textured = false;
  for (std::size_t mesh = 0; mesh < scene.meshes.size(); ++mesh) textured |= variant_of(mesh).textured;
  if (textured) sets.push_back(*buffers_.texture_layout);
  layout_ = device_.logical.createPipelineLayout(
      {.setLayoutCount = narrow<std::uint32_t>(sets.size()), .pSetLayouts = sets.data()});
  if (!plan.builds_late) make_all_pipelines();
}

void ScenePass::make_all_pipelines() {
  for (std::size_t mesh = 0; mesh < scene_.meshes.size(); ++mesh) need_pipeline(variant_of(mesh));
}

void ScenePass::prepare_warm_up() {
  make_all_pipelines();
  instances_.view<gpu::InstanceData>().fill({});  // every corner at w = 0
  draws_[0].clear();
  std::set<SceneVariant> drawn;
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i)
    if (drawn.insert(variant_of(scene_.instances[i].mesh)).second)
      draws_[0].push_back({.instance = i,
                           .data = i,
                           .first_eye = 0,
                           .eyes = 2,
                           .count = buffers_.meshes[scene_.instances[i].mesh].ranges[0].count});
}

SceneVariant ScenePass::variant_of(std::size_t mesh) const {
  return variant_for(plan_.surfaces[mesh], outputs_);
}

void ScenePass::need_pipeline(SceneVariant variant) {
  if (!pipelines_->contains(variant))
    pipelines_->emplace(variant, make_scene_pipeline(device_, layout_, plan_, outputs_, variant));
}

/// Bytes that a draw reads for one eye, if all parts of its level read equally many vertices.
std::uint64_t ScenePass::bytes_read(std::size_t mesh, const Draw& draw) const {
  const StreamBytes& bytes = buffers_.meshes[mesh].bytes;
  const SceneVariant variant = variant_of(mesh);
  const std::uint64_t streams = bytes.positions + (outputs_ == Outputs::GBuffer ? bytes.normals : 0) +
                                (variant.textured ? bytes.uvs : 0) + (variant.colored ? bytes.colors : 0);
  const IndexRange& range = buffers_.meshes[mesh].ranges[draw.level];
  const std::size_t vertices = scene_.meshes[mesh].positions.size();
  const std::uint64_t read = std::uint64_t{range.vertices} * draw.count / std::max(range.count, 1u);
  return streams / std::max(vertices, std::size_t{1}) * read + draw.count * index_bytes(vertices);
}

void ScenePass::clear_counts() {
  vertex_bytes_read_ = triangles_ = 0;
}

void ScenePass::prepare(const StereoView& views, const SceneState& state, Detail detail) {
  clear_counts();
  deform(state);
  add_draws(0, {0, {}, {Casters::Seen, Casters::Seen}}, state, {views[0].size, views[1].size}, detail,
            [&](const Affine<Stage, Object>& stage_from_object) {
              return instance_data(views, stage_from_object);
            });
}

void ScenePass::prepare(std::span<const CasterDraws> passes, Extent size, const SceneState& state) {
  check(outputs_ != Outputs::GBuffer, "normals are seen by eyes");
  clear_counts();
  deform(state);
  if (draws_.size() < passes.size()) draws_.resize(passes.size());
  for (std::size_t pass = 0; pass < passes.size(); ++pass)
    add_draws(pass, passes[pass], state, {size, size}, Detail::Levels,
              [&](const Affine<Stage, Object>& stage_from_object) {
                gpu::InstanceData data{};
                for (std::size_t layer = 0; layer < kEyes; ++layer)
                  data.clip_from_object[layer] =
                      glm::mat4(passes[pass].clip_from_stage[layer] * stage_from_object.matrix);
                return data;
              });
}

/// The level of an instance in each layer. Eyes share the level that the nearer one needs, and keep it within
/// the hysteresis. A layer of a shadow map has the level that its view alone asks for, so that a map that is
/// drawn again in part equals one that is drawn as a whole.
PerEye<std::uint32_t> ScenePass::levels_for(std::uint32_t instance, const gpu::InstanceData& data,
                                            const PerEye<Extent>& sizes) {
  const DeviceMesh& mesh = buffers_.meshes[scene_.instances[instance].mesh];
  if (mesh.levels.empty() || plan_.detail_px <= 0) return {0, 0};
  PerEye<double> px_per_unit{0, 0};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    if (may_be_seen(data, eye, mesh.box))
      px_per_unit[eye] = pixels_per_unit(glm::dmat4(data.clip_from_object[eye]), mesh.box, sizes[eye]);
  const auto choose = [&](double px, std::uint32_t last) {
    return choose_level(mesh.levels, px, plan_.detail_px, last);
  };
  if (outputs_ == Outputs::Casters) {
    const auto coarsest = narrow<std::uint32_t>(mesh.levels.size());
    return {choose(px_per_unit[0], coarsest), choose(px_per_unit[1], coarsest)};
  }
  std::uint32_t& last = last_levels_[instance];
  last = choose(std::max(px_per_unit[0], px_per_unit[1]), last);
  return {last, last};
}

const Bounds& ScenePass::box_of(std::size_t instance) const {
  const DeformedVertices::Place* deformed = deformed_->of(instance);
  return deformed != nullptr ? deformed->box : buffers_.meshes[scene_.instances[instance].mesh].box;
}

bool ScenePass::wants(Casters casters, std::size_t instance) const {
  if (casters == Casters::None || casters == Casters::Seen) return casters == Casters::Seen;
  if (!scene_.instances[instance].casts || casters == Casters::All) return scene_.instances[instance].casts;
  return can_move(scene_, scene_.instances[instance]) == (casters == Casters::Moving);
}

/// Adds draws of those clusters of a level that may be seen; successive ones become one draw.
void ScenePass::add_visible(Draw draw, const gpu::InstanceData& data, std::vector<Draw>& draws) {
  const IndexRange& range = buffers_.meshes[scene_.instances[draw.instance].mesh].ranges[draw.level];
  constexpr std::uint32_t kIndices = 3 * kClusterTriangles;
  draw.first = range.first;
  draw.count = 0;
  const auto is_seen = [&](const Bounds& cluster) {
    for (std::uint32_t eye = draw.first_eye; eye < draw.first_eye + draw.eyes; ++eye)
      if (may_be_seen(data, eye, cluster)) return true;
    return false;
  };
  std::uint32_t left = range.count;
  for (const Bounds& cluster : range.clusters) {
    const std::uint32_t indices = std::min(left, kIndices);
    left -= indices;
    if (range.clusters.size() == 1 || is_seen(cluster)) {
      draw.count += indices;
      continue;
    }
    if (draw.count > 0) add_draw(draw, draws);
    draw.first += draw.count + indices;
    draw.count = 0;
  }
  if (draw.count > 0) add_draw(draw, draws);
}

void ScenePass::add_draw(const Draw& draw, std::vector<Draw>& draws) {
  const std::uint32_t mesh = scene_.instances[draw.instance].mesh;
  draws.push_back(draw);
  need_pipeline(variant_of(mesh));
  vertex_bytes_read_ += bytes_read(mesh, draw) * draw.eyes;
  triangles_ += std::uint64_t{draw.count / 3} * draw.eyes;
}

template <class SeenAs>
void ScenePass::add_draws(std::size_t pass, const CasterDraws& wanted, const SceneState& state,
                          const PerEye<Extent>& sizes, Detail detail, const SeenAs& seen_as) {
  const auto first = narrow<std::uint32_t>(wanted.pair * scene_.instances.size());
  std::vector<Draw>& draws = draws_[pass];
  draws.clear();
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
    const bool in_left = wants(wanted.casters[0], i), in_right = wants(wanted.casters[1], i);
    if ((!in_left && !in_right) || is_singular(glm::dmat3(state.stage_from_object[i].matrix))) continue;
    const DeviceMesh& mesh = buffers_.meshes[scene_.instances[i].mesh];
    Affine<Stage, Object> stage_from_mesh = state.stage_from_object[i];
    stage_from_mesh.matrix[3] = glm::dvec4(stage_from_mesh(Point<Object>{mesh.center}).v, 1.0);
    gpu::InstanceData seen = seen_as(stage_from_mesh);
    const Bounds& box = box_of(i);
    const bool left = in_left && may_be_seen(seen, 0, box), right = in_right && may_be_seen(seen, 1, box);
    if (!left && !right) continue;
    const Material& material = scene_.materials[scene_.meshes[scene_.instances[i].mesh].material];
    seen.base_color = material.base_color;
    seen.index = i;
    seen.alpha_cutoff = material.alpha_cutoff.value_or(0.0f);
    instances_.write(first + i, seen);
    const glm::vec3 middle = (glm::vec3(box.low) + glm::vec3(box.high)) * 0.5f;
    const glm::vec4 centre = seen.clip_from_object[0] * glm::vec4(middle, 1.0f);
    Draw draw{.instance = i,
              .data = first + i,
              .distance = centre.w,
              .mirrored = glm::determinant(glm::dmat3(state.stage_from_object[i].matrix)) < 0};
    const PerEye<std::uint32_t> levels =
        detail == Detail::Full ? PerEye<std::uint32_t>{0, 0} : levels_for(i, seen, sizes);
    draw.level = levels[left ? 0 : 1];
    draw.first_eye = left ? 0 : 1;
    draw.eyes = left && right && levels[0] == levels[1] ? 2 : 1;
    add_visible(draw, seen, draws);
    if (!left || !right || draw.eyes == 2) continue;
    draw.level = levels[1];
    draw.first_eye = 1;
    add_visible(draw, seen, draws);
  }
  // Nearest first, so that the depth test rejects most hidden pixels before shading.
  std::stable_sort(draws.begin(), draws.end(),
                   [](const Draw& a, const Draw& b) { return a.distance < b.distance; });
}

void ScenePass::record_uploads(const vk::raii::CommandBuffer& commands, const HiddenPass* hidden) const {
  std::vector<const gpu::UploadBuffer*> read{&frame_, &instances_};
  if (deformed_->upload() != nullptr) read.push_back(deformed_->upload());
  if (hidden != nullptr) read.push_back(&hidden->upload());
  gpu::record_uploads(commands, read);
}

void ScenePass::record(const vk::raii::CommandBuffer& commands, Extent size,
                       std::span<const vk::RenderingAttachmentInfo> colors,
                       const vk::RenderingAttachmentInfo& depth, std::size_t pass,
                       std::span<const vk::ClearRect> clears, const HiddenPass* hidden) const {
  record_uploads(commands, hidden);
  const vk::Rect2D area{.extent = {size.width, size.height}};
  commands.beginRendering({.renderArea = area,
                           .layerCount = kEyes,
                           .colorAttachmentCount = narrow<std::uint32_t>(colors.size()),
                           .pColorAttachments = colors.data(),
                           .pDepthAttachment = &depth});
  if (!clears.empty())
    commands.clearAttachments(vk::ClearAttachment{.aspectMask = vk::ImageAspectFlagBits::eDepth},
                              vk::ArrayProxy(narrow<std::uint32_t>(clears.size()), clears.data()));
  commands.setViewport(0, vk::Viewport{.width = static_cast<float>(size.width),
                                       .height = static_cast<float>(size.height),
                                       .maxDepth = 1});
  commands.setScissor(0, area);
  if (hidden != nullptr) hidden->record(commands, HiddenPass::As::Nearest);
  for (const Draw& draw : draws_[pass]) {
    const Material& material = scene_.materials[scene_.meshes[scene_.instances[draw.instance].mesh].material];
    const bool both_sides = material.double_sided || outputs_ == Outputs::Casters;
    commands.setCullMode(both_sides ? vk::CullModeFlagBits::eNone : vk::CullModeFlagBits::eBack);
    commands.setFrontFace(draw.mirrored ? vk::FrontFace::eClockwise : vk::FrontFace::eCounterClockwise);
    draw_instance(commands, draw);
  }
  if (hidden != nullptr) hidden->record(commands, HiddenPass::As::NoSurface);
  commands.endRendering();
}

void ScenePass::draw_instance(const vk::raii::CommandBuffer& commands, const Draw& draw) const {
  const std::uint32_t mesh_index = scene_.instances[draw.instance].mesh;
  const DeviceMesh& mesh = buffers_.meshes[mesh_index];
  const SceneVariant variant = variant_of(mesh_index);
  commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipelines_->at(variant));
  if (variant.textured)
    commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout_, 1,
                                *buffers_.texture_sets[*mesh.texture].set, {});
  std::array<vk::Buffer, 4> streams;
  streams.fill(*buffers_.vertices.buffer);
  std::array<vk::DeviceSize, 4> offsets{mesh.offsets.positions};
  std::uint32_t count = 1;
  if (outputs_ == Outputs::GBuffer) offsets[count++] = mesh.offsets.normals;
  if (const DeformedVertices::Place* deformed = deformed_->of(draw.instance)) {
    streams[0] = deformed_->buffer(), offsets[0] = deformed->positions;
    if (outputs_ == Outputs::GBuffer) streams[1] = deformed_->buffer(), offsets[1] = deformed->normals;
  }
  if (variant.textured) offsets[count++] = mesh.offsets.uvs;
  if (variant.colored) offsets[count++] = mesh.offsets.colors;
  commands.bindVertexBuffers(0, vk::ArrayProxy(count, streams.data()), vk::ArrayProxy(count, offsets.data()));
  commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout_, 0, *bindings_.set,
                              narrow<std::uint32_t>(draw.data * sizeof(gpu::InstanceData)));
  commands.bindIndexBuffer(*buffers_.indices.buffer, mesh.offsets.indices, mesh.index_type);
  commands.drawIndexed(draw.count, draw.eyes, draw.first, 0, draw.first_eye);
}

}  // namespace farshade
