#include "stereo/reproject/shading.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "stereo/frame/edge_sharpness.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/reproject/shading_motion.h"
#include "stereo/reproject/shown_eye.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

static_assert(kMaxMasks * kEyes == FARSHADE_FIRST_FACE && kCubeMaskPairs == FARSHADE_MAX_CUBE_MASK_PAIRS &&
              kFirstFace + kCubeMaskPairs * kEyes == FARSHADE_MAX_SOURCES &&
              kMaxMasks + kCubeMaskPairs == FARSHADE_MAX_TRACED && kMostSpheres == FARSHADE_MAX_MOVED);

static_assert(sizeof(gpu::FrameData) <= gpu::kUniformRange_bytes &&
              (kMaxLights + 1) * sizeof(gpu::LightData) <= gpu::kUniformRange_bytes);

/// Views that differ by a larger turn have almost nothing in common, so the newest mask is no guess.
constexpr double kMeaninglessTurn_rad = 0.25;

constexpr gpu::BindingKind kStorage{vk::DescriptorType::eStorageBuffer, vk::ShaderStageFlagBits::eCompute};

/// Set 0 of shade.comp. It has the last bindings only if masks are reprojected, if instances can move, and if
/// hard pixels are listed.
std::vector<gpu::BindingKind> shading_set(const DrawPlan& plan, const ShadingBytes& bytes) {
  using Type = vk::DescriptorType;
  const auto compute = vk::ShaderStageFlagBits::eCompute;
  const gpu::BindingKind uniform{Type::eUniformBuffer, compute},
      texture{Type::eCombinedImageSampler, compute};
  std::vector<gpu::BindingKind> kinds{uniform, uniform, kStorage, kStorage,
                                      texture, texture, texture,  {Type::eStorageImage, compute}};
  if (reprojects_masks(plan)) kinds.insert(kinds.end(), 1 + kMaxMasks, texture);
  if (bytes.motions > 0) kinds.insert(kinds.end(), 2, kStorage);
  if (bytes.lists > 0) kinds.push_back(kStorage);
  return kinds;
}

/// The passes that `plan` may need. MOVING has pixels only if instances can move.
std::vector<std::uint32_t> passes_of(const DrawPlan& plan, Changes moves) {
  std::vector<std::uint32_t> passes{FARSHADE_PASS_DIRECT};
  if (!reprojects_masks(plan)) return passes;
  if (plan.passes == ShadingPasses::Single) {
    passes.push_back(FARSHADE_PASS_SINGLE);
    return passes;
  }
  passes.insert(passes.end(), {FARSHADE_PASS_EASY, FARSHADE_PASS_HARD});
  if (plan.edge_rays) passes.insert(passes.end(), {FARSHADE_PASS_RAYS, FARSHADE_PASS_FLIPPED});
  if (moves == Changes::Possible) passes.push_back(FARSHADE_PASS_MOVING);
  return passes;
}

/// The list that a pass works on.
std::uint32_t list_of(std::uint32_t pass) {
  switch (pass) {
    case FARSHADE_PASS_MOVING:
      return FARSHADE_LIST_MOVING;
    case FARSHADE_PASS_RAYS:
      return FARSHADE_LIST_EDGES;
    case FARSHADE_PASS_FLIPPED:
      return FARSHADE_LIST_FLIPPED;
    default:
      return FARSHADE_LIST_HARD;
  }
}

std::vector<const TracedMask*> taken(std::span<const DatedMask> masks) {
  std::vector<const TracedMask*> result;
  for (const DatedMask& dated : masks) result.push_back(&dated.mask);
  return result;
}

std::vector<const Motion*> motions(std::span<const DatedMask> masks) {
  std::vector<const Motion*> result;
  for (const DatedMask& dated : masks) result.push_back(&dated.motion);
  return result;
}

using At = vk::PipelineStageFlagBits2;
using Access = vk::AccessFlagBits2;

void barrier(const vk::raii::CommandBuffer& commands, vk::PipelineStageFlags2 from, vk::AccessFlags2 written,
             vk::PipelineStageFlags2 to, vk::AccessFlags2 read) {
  const vk::MemoryBarrier2 memory{
      .srcStageMask = from, .srcAccessMask = written, .dstStageMask = to, .dstAccessMask = read};
  commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &memory});
}

}  // namespace

ShadingPass::ShadingPass(gpu::FramesInFlight& frames, const DrawPlan& plan, const GBufferPass* gbuffer,
                         const MaskDepths& depths, DeviceMasks& device_masks, gpu::UploadBuffer& frame,
                         const MotionModel& motion, const ShadingBytes& bytes, Extent size,
                         EdgeRays* edge_rays)
    : frames_(frames),
      device_(frames.device()),
      plan_(plan),
      depths_(depths),
      device_masks_(device_masks),
      frame_buffer_(frame),
      size_(size),
      bytes_(bytes),
      edge_rays_(edge_rays),
      motion_count_(motion.slot_count()),
      pipelines_(device_, plan, motion.slot_count() > 0) {
  check(fits_dispatches(size, device_.max_groups), "the device allows the workgroups of a picture");
  make_buffers(motion);
  if (gbuffer != nullptr) make_picture();
  nearest_ = device_.logical.createSampler({});
  for (std::size_t place = 0; place < frames.count(); ++place) frame_sets_.push_back(make_set(gbuffer));
  if (edge_rays_ != nullptr) {
    const std::array<vk::DescriptorSetLayout, 2> sets{*frame_sets_[0].bindings.layout,
                                                      *edge_rays_->bindings().layout};
    ray_layout_ = device_.logical.createPipelineLayout({.setLayoutCount = narrow<std::uint32_t>(sets.size()),
                                                        .pSetLayouts = sets.data(),
                                                        .pushConstantRangeCount = 1,
                                                        .pPushConstantRanges = &kShownEye});
  }
  if (!plan.builds_late) make_all_pipelines();
}

void ShadingPass::make_buffers(const MotionModel& motion) {
  const auto storage = vk::BufferUsageFlagBits::eStorageBuffer;
  light_buffer_ = gpu::make_upload_buffer(frames_, bytes_.lights, vk::BufferUsageFlagBits::eUniformBuffer,
                                          "lights", gpu::Use::Frame);
  if (bytes_.motions > 0) {
    const auto upload = [&](std::size_t bytes, const char* name) {
      return gpu::make_upload_buffer(frames_, bytes, storage, name, gpu::Use::Motion);
    };
    motion_slots_ = upload(bytes_.slots, "motion slots");
    const WriteOnly<std::uint32_t> slots = motion_slots_.view<std::uint32_t>();
    slots.fill(0);
    slots.copy(motion.slots());
    motion_buffer_ = upload(bytes_.motions, "motions");
  }
  if (bytes_.lists > 0)
    list_buffer_ = gpu::make_device_buffer(device_, bytes_.lists,
                                           storage | vk::BufferUsageFlagBits::eTransferSrc |
                                               vk::BufferUsageFlagBits::eTransferDst |
                                               vk::BufferUsageFlagBits::eIndirectBuffer,
                                           "lists", gpu::Use::Lists);
}

void ShadingPass::make_picture() {
  shown_ = gpu::make_image(device_,
                           {.size = size_,
                            .layers = kEyes,
                            .format = vk::Format::eR8G8B8A8Unorm,
                            .usage = vk::ImageUsageFlagBits::eStorage | vk::ImageUsageFlagBits::eTransferSrc |
                                     vk::ImageUsageFlagBits::eSampled,
                            .use = gpu::Use::Shown},
                           "shown");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, shown_, Layout::eUndefined, Layout::eGeneral);
  });
}

ShadingPass::FrameSet ShadingPass::make_set(const GBufferPass* gbuffer) const {
  FrameSet set{gpu::make_bindings(device_, shading_set(plan_, bytes_), "shading")};
  const gpu::Bindings& bindings = set.bindings;
  std::uint32_t binding = 0;
  for (const gpu::UploadBuffer* upload : {&std::as_const(frame_buffer_), &std::as_const(light_buffer_),
                                          &device_masks_.words(), &device_masks_.known_blocks()})
    gpu::bind_buffer(device_, bindings, binding++, upload->buffer());
  check_eq(binding, std::uint32_t{FARSHADE_BINDING_SHOWN_DEPTH}, "binding of the shown depth");
  if (gbuffer != nullptr) {
    bind_texture(set, FARSHADE_BINDING_BASE_COLORS, *gbuffer->base_colors().view);
    bind_texture(set, FARSHADE_BINDING_SURFACES, *gbuffer->surfaces().view);
    gpu::bind_image(device_, bindings, FARSHADE_BINDING_OUTPUT, {*shown_.view, Layout::eGeneral, nullptr});
  } else {
    bind_texture(set, FARSHADE_BINDING_BASE_COLORS, depths_.any.view);  // lavapipe needs all bound
  }
  binding = FARSHADE_BINDING_OUTPUT + 1;
  if (reprojects_masks(plan_)) {
    // Without a cube mask its depth is not read.
    const gpu::Image& faces = depths_.faces ? depths_.faces->images().front() : *depths_.any.image;
    gpu::bind_image(device_, bindings, binding++, {*faces.view, Layout::eShaderReadOnlyOptimal, *nearest_});
    check_eq(binding, std::uint32_t{FARSHADE_BINDING_MASK_DEPTHS}, "first binding of the depth of masks");
    binding += kMaxMasks;
  }
  for (const gpu::UploadBuffer* upload : {&motion_slots_, &motion_buffer_})
    if (upload->bytes() > 0) gpu::bind_buffer(device_, bindings, binding++, upload->buffer());
  if (bytes_.lists > 0) gpu::bind_buffer(device_, bindings, binding++, list_buffer_, bytes_.arguments);
  check_eq(std::size_t{binding}, bindings.kinds.size(), "bindings of the shading pass");
  bind_depths(set, depths_.any, {});
  return set;
}

/// Writes the sources of each shown eye: the masks traced for it and, if used, those for the other eye.
void ShadingPass::write_sources(const StereoView& views, std::span<const DatedMask> masks,
                                gpu::FrameData& frame) {
  frame.counts.x = narrow<std::uint32_t>(masks.size());
  const std::vector<DeviceMasks::Held> held = device_masks_.hold(DeviceMasks::Kind::Views, taken(masks));
  for (std::size_t m = 0; m < masks.size(); ++m) {
    const TracedMask& mask = masks[m].mask;
    whole_ &= held[m].whole;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::size_t traced = 0; traced < kEyes; ++traced) {
        if (traced != eye && !other_eye_) continue;
        const std::size_t i = m + (traced == eye ? 0 : kMaxMasks);
        gpu::SourceData& source = frame.sources[eye * FARSHADE_MAX_SOURCES + i];
        source = source_data(pose_delta(views[eye], {}, mask.views[traced], {}), mask.views[traced]);
        source.place = device_masks_.place(held[m], traced, 0);
      }
  }
}

/// Writes the faces of the cube mask, which are sources of both eyes.
void ShadingPass::write_faces(const StereoView& views, std::span<const DatedMask> cube_mask,
                              gpu::FrameData& frame) {
  frame.counts.w = narrow<std::uint32_t>(cube_mask.size() * kEyes);
  const std::vector<DeviceMasks::Held> held =
      device_masks_.hold(DeviceMasks::Kind::CubeMask, taken(cube_mask));
  for (std::size_t m = 0; m < cube_mask.size(); ++m) {
    const TracedMask& mask = cube_mask[m].mask;
    whole_ &= held[m].whole;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::size_t face = 0; face < kEyes; ++face) {
        gpu::SourceData& source = frame.sources[eye * FARSHADE_MAX_SOURCES + kFirstFace + m * kEyes + face];
        source = source_data(pose_delta(views[eye], {}, mask.views[face], {}), mask.views[face]);
        source.place = device_masks_.place(held[m], face, depths_.faces->place_of(mask.frame).layer);
      }
  }
}

void ShadingPass::write_motion(const StereoView& views, const MasksInUse& masks, gpu::FrameData& frame) {
  const std::vector<const Motion*> of_views = motions(masks.views), of_faces = motions(masks.cube_mask);
  const MaskMotions since{of_views, of_faces};
  // Where instances can move, one pipeline serves all frames, because compiling another takes long.
  moved_ = write_stale(views, since, frame) || motion_count_ > 0;
  if (!plan_.builds_late) assume_nothing();
  if (!moved_) return;
  if (motion_count_ == 0) return;
  const WriteOnly<glm::mat4> matrices = motion_buffer_.view<glm::mat4>();
  for (std::size_t slot = 0; slot < motion_count_; ++slot) write_motions(views, since, slot, matrices);
}

namespace {

/// Rays can be traced to `lights`, unless they have moved since the newest mask was traced. Returns whether
/// any are left.
bool write_ray_lights(const LightBits& lights, MaskLayout mask, gpu::FrameData& frame) {
  bool any = false, all = true;
  for (std::uint32_t plane = 0; plane < mask.planes(); ++plane) {
    const int vector = static_cast<int>(plane / 4), word = static_cast<int>(plane % 4);
    const std::uint32_t stale = frame.stale_lights[FARSHADE_SINCE_NEWEST * 2 + vector][word];
    frame.ray_lights[vector][word] = lights[plane] & ~stale;
    any = any || frame.ray_lights[vector][word] != 0;
    all = all && frame.ray_lights[vector][word] == mask.used_bits(plane);
  }
  frame.counts.y = all;
  return any;
}

}  // namespace

void ShadingPass::prepare(const DepthPlace& shown, const StereoView& views, const LightSet& lights,
                          const MasksInUse& in_use, const Reprojection& reprojection) {
  const std::span<const DatedMask> masks = in_use.views;
  check(masks.size() <= most_masks(plan_) && in_use.cube_mask.size() <= most_cube_mask_pairs(plan_),
        "no more masks than the device holds");
  check_eq(lights.lights.size(), std::size_t{plan_.mask.lights}, "lights of the scene and of the plan");
  reprojection_ = reprojection;
  if (!reprojects_masks(plan_)) reprojection_.lookup = Lookup::Direct;
  other_eye_ = plan_.other_eye && reprojection.eyes == Eyes::Both &&
               (!plan_.builds_late || (!masks.empty() && masks[0].mask.views[0] != masks[0].mask.views[1]));
  gpu::FrameData frame{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) frame.eye[eye] = eye_data(views[eye]);
  whole_ = true;
  LightBits rays{};
  if (edge_rays_ != nullptr && reprojection_.edges == Edges::Exact) rays = edge_rays_->prepare(views, lights);
  if (reprojection_.lookup != Lookup::Direct) device_masks_.set_ray_lights(rays);
  write_sources(views, masks, frame);
  write_faces(views, in_use.cube_mask, frame);
  masks_ = masks.size();
  faces_ = in_use.cube_mask.size() * kEyes;
  write_motion(views, in_use, frame);
  write_spheres(views, in_use.movable, frame.movable);
  bind_depths(frame_sets_[frames_.place()], shown, masks);
  if (!masks.empty()) {
    const PoseDelta delta = pose_delta(views[0], {}, masks[0].mask.views[0], {});
    frame.counts.z = delta.angle_rad < kMeaninglessTurn_rad;
    frame.direct = pixel_map(views[0], masks[0].mask.views[0]);
  }
  maps_ = nullptr;
  traces_rays_ = write_ray_lights(rays, plan_.mask, frame);
  write_frame(views, lights, frame);
}

void ShadingPass::write_frame(const StereoView& views, const LightSet& lights, const gpu::FrameData& frame) {
  gpu::FrameData lit = frame;
  lit.ambient = glm::vec4(glm::vec3(plan_.ambient), 0);
  frame_buffer_.write(0, lit);
  for (std::size_t i = 0; i < lights.lights.size(); ++i) {
    light_buffer_.write(i, light_data(views, lights.lights[i], lights.exposure));
    off_[i] = !lights.lights[i].on;
  }
}

/// Pipelines that are created before the first frame must be right for any frame.
void ShadingPass::assume_nothing() {
  whole_ = false;
  moved_ = true;
}

/// Creates the pipelines of the default Reprojection.
void ShadingPass::make_all_pipelines() {
  assume_nothing();
  other_eye_ = plan_.other_eye;
  for (const bool traces : {false, edge_rays_ != nullptr}) {
    traces_rays_ = traces;
    for (const std::uint32_t pass : passes_of(plan_, Changes::Possible))
      need_pipeline(pass, PixelReport::Off);
  }
}

std::vector<gpu::Recording> ShadingPass::warm_ups(const Reprojection& reprojection, PixelReport report,
                                                  Changes changes) {
  if (report == PixelReport::On) make_report_buffer();
  reprojection_ = reprojection;
  other_eye_ = plan_.other_eye && reprojection.eyes == Eyes::Both;
  const std::vector<std::uint32_t> passes = passes_of(plan_, motion_count_ > 0 ? changes : Changes::Never);
  std::set<ShadingKey> keys;
  for (const auto& [whole, moved] : {std::pair(true, false), {false, false}, {false, true}}) {
    if (moved ? changes == Changes::Never : motion_count_ > 0) continue;
    whole_ = whole;
    moved_ = moved;
    for (const bool traces : {false, edge_rays_ != nullptr && reprojection.edges == Edges::Exact}) {
      traces_rays_ = traces;
      for (const std::uint32_t pass : passes) keys.insert(key_of(pass, report));
    }
  }
  std::set<ShadingKey> rays;
  for (auto key = keys.begin(); key != keys.end();)
    key->pass == FARSHADE_PASS_RAYS ? static_cast<void>(rays.insert(keys.extract(key++)))
                                    : static_cast<void>(++key);
  pipelines_.need_all(keys, need_layout(report));
  pipelines_.need_all(rays, ray_layout_);
  std::vector<gpu::Recording> warm_ups;
  keys.merge(rays);
  for (const ShadingKey& key : keys)
    warm_ups.emplace_back([this, key, report](const vk::raii::CommandBuffer& commands) {
      const vk::raii::PipelineLayout& layout = layout_of(key.pass, report);
      key.pass == FARSHADE_PASS_RAYS ? bind_ray_sets(commands) : bind_sets(commands, report);
      if (bytes_.lists > 0) empty_lists(commands);
      commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipelines_.need(key, layout));
      push_shown_eye(commands, layout, 0);
      commands.dispatch(0, 1, 1);  // compiles, but runs nothing: the buffers have no contents yet
    });
  return warm_ups;
}

const vk::raii::PipelineLayout& ShadingPass::layout_of(std::uint32_t pass, PixelReport report) {
  return pass == FARSHADE_PASS_RAYS ? ray_layout_ : need_layout(report);
}

const vk::raii::Pipeline& ShadingPass::need_pipeline(std::uint32_t pass, PixelReport report) {
  return pipelines_.need(key_of(pass, report), layout_of(pass, report));
}

/// State that a pass does not read has one value in all of its keys, so that no pipeline is compiled twice.
/// Where something has moved, one pipeline serves whole masks and others.
ShadingKey ShadingPass::key_of(std::uint32_t pass, PixelReport report) const {
  const bool second_look =
                 pass == FARSHADE_PASS_HARD || pass == FARSHADE_PASS_MOVING || pass == FARSHADE_PASS_SINGLE,
             direct = pass == FARSHADE_PASS_DIRECT;
  return {.pass = pass,
          .reports = report == PixelReport::On && pass != FARSHADE_PASS_RAYS,
          .visibility = writes_visibilities() && pass != FARSHADE_PASS_RAYS,
          .edge_rays = pass == FARSHADE_PASS_EASY && traces_rays_,
          .other_eye = second_look && other_eye_,
          .neighbours = !second_look || reprojection_.gaps == Gaps::Neighbours,
          .filters_edges = direct || reprojection_.edges != Edges::Nearest,
          .whole = whole_ && !direct && !moved_,
          .moved = moved_ && !direct,
          .map_side_px = maps_ != nullptr ? maps_->settings().side_px : 0,
          .pcf_radius = maps_ != nullptr ? maps_->settings().pcf_radius : 0,
          .sharpness = maps_ != nullptr                         ? maps_->settings().sharpness
                       : reprojection_.edges == Edges::Coverage ? 0.0f
                                                                : kEdgeSharpness};
}

/// Created when a report is first requested, because the report is large.
void ShadingPass::make_report_buffer() {
  if (report_buffer_.bytes > 0) return;
  report_buffer_ = gpu::make_readback_buffer(device_, bytes_.report, vk::BufferUsageFlagBits::eStorageBuffer,
                                             "report", gpu::Use::Report);
  report_bindings_ = gpu::make_bindings(device_, {kStorage}, "report");
  gpu::bind_buffer(device_, report_bindings_, 0, report_buffer_);
}

void ShadingPass::bind(const vk::raii::CommandBuffer& commands, std::uint32_t pass, PixelReport report) {
  commands.bindPipeline(vk::PipelineBindPoint::eCompute, *need_pipeline(pass, report));
}

void ShadingPass::shade_all(const vk::raii::CommandBuffer& commands, std::uint32_t pass, PixelReport report) {
  bind(commands, pass, report);
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    push_shown_eye(commands, need_layout(report), eye);
    const GroupCounts groups = picture_groups(size_);
    commands.dispatch(groups[0], groups[1], 1);
  }
}

void ShadingPass::shade_listed(const vk::raii::CommandBuffer& commands, std::uint32_t pass,
                               PixelReport report) {
  bind(commands, pass, report);
  dispatch_list(commands, need_layout(report), list_of(pass));
}

void ShadingPass::dispatch_list(const vk::raii::CommandBuffer& commands,
                                const vk::raii::PipelineLayout& layout, std::uint32_t list) const {
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    push_shown_eye(commands, layout, eye);
    commands.dispatchIndirect(*list_buffer_.buffer,
                              bytes_.arguments + (eye * FARSHADE_LISTS + list) * sizeof(glm::uvec4));
  }
}

void ShadingPass::empty_lists(const vk::raii::CommandBuffer& commands) const {
  std::array<glm::uvec4, FARSHADE_LISTS * kEyes> empty;
  empty.fill({0, 0, 1, 0});
  commands.updateBuffer<glm::uvec4>(*list_buffer_.buffer, 0, empty);
  barrier(commands, At::eTransfer, Access::eTransferWrite, At::eComputeShader,
          Access::eShaderRead | Access::eShaderWrite);
}

/// What has been listed is there for the next dispatches. The arguments of a dispatch may not lie where its
/// shader could write.
void ShadingPass::copy_arguments(const vk::raii::CommandBuffer& commands) const {
  barrier(commands, At::eComputeShader | At::eDrawIndirect,
          Access::eShaderWrite | Access::eIndirectCommandRead, At::eComputeShader | At::eTransfer,
          Access::eShaderRead | Access::eShaderWrite | Access::eTransferRead | Access::eTransferWrite);
  commands.copyBuffer(*list_buffer_.buffer, *list_buffer_.buffer,
                      vk::BufferCopy{.dstOffset = bytes_.arguments, .size = kListHeads_bytes});
  barrier(commands, At::eTransfer, Access::eTransferRead | Access::eTransferWrite,
          At::eComputeShader | At::eDrawIndirect, Access::eShaderWrite | Access::eIndirectCommandRead);
}

void ShadingPass::shade_sorted(const vk::raii::CommandBuffer& commands, PixelReport report) {
  empty_lists(commands);
  shade_all(commands, FARSHADE_PASS_EASY, report);
  copy_arguments(commands);
  if (traces_rays_) {
    record_edge_rays(commands);
    bind_sets(commands, report);
    shade_listed(commands, FARSHADE_PASS_FLIPPED, report);
  }
  shade_listed(commands, FARSHADE_PASS_HARD, report);
  if (moved_ && motion_count_ > 0) shade_listed(commands, FARSHADE_PASS_MOVING, report);
}

void ShadingPass::bind_ray_sets(const vk::raii::CommandBuffer& commands) const {
  const std::array<vk::DescriptorSet, 2> sets{*set_now().bindings.set, *edge_rays_->bindings().set};
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *ray_layout_, 0, sets, {});
}

void ShadingPass::record_edge_rays(const vk::raii::CommandBuffer& commands) {
  bind_ray_sets(commands);
  bind(commands, FARSHADE_PASS_RAYS, PixelReport::Off);
  dispatch_list(commands, ray_layout_, list_of(FARSHADE_PASS_RAYS));
  copy_arguments(commands);
}

void ShadingPass::record(const vk::raii::CommandBuffer& commands, PixelReport report) {
  if (report == PixelReport::On) make_report_buffer();
  gpu::record_uploads(commands, {&frame_buffer_, &light_buffer_, &motion_slots_, &motion_buffer_,
                                 &device_masks_.words(), &device_masks_.known_blocks()});
  if (edge_rays_ != nullptr) edge_rays_->record_uploads(commands);
  bind_sets(commands, report);
  if (!writes_visibilities()) gpu::transition(commands, shown_, Layout::eUndefined, Layout::eGeneral);
  if (reprojection_.lookup == Lookup::Direct || masks_ + faces_ == 0) {
    shade_all(commands, FARSHADE_PASS_DIRECT, report);
  } else if (plan_.passes == ShadingPasses::Single) {
    shade_all(commands, FARSHADE_PASS_SINGLE, report);
  } else {
    shade_sorted(commands, report);
  }
  barrier(commands, At::eComputeShader, Access::eShaderWrite, At::eHost | At::eTransfer,
          Access::eHostRead | Access::eTransferRead);
}

}  // namespace farshade
