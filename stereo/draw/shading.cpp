#include "stereo/draw/shading.h"

#include <algorithm>
#include <bit>

#include "shaders/shade.comp.spv.h"
#include "shaders/shade_direct.comp.spv.h"
#include "shaders/shade_direct_report.comp.spv.h"
#include "shaders/shade_maps.comp.spv.h"
#include "shaders/shade_maps_report.comp.spv.h"
#include "shaders/shade_motion.comp.spv.h"
#include "shaders/shade_motion_report.comp.spv.h"
#include "shaders/shade_report.comp.spv.h"
#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

constexpr std::uint32_t kGroup_px = 64;  // as in shade.comp
static_assert(kTileSide_px == FARSHADE_TILE_PX);
static_assert(ShadingPass::kMaxMasks * kEyes == FARSHADE_MAX_SOURCES && kMostSpheres == FARSHADE_MAX_MOVED);

/// A filtered visibility is pulled this much away from a half; docs/reprojection.md has the measurement.
constexpr float kSharpness = 4.0f;

/// A view turned further than this has next to nothing in common with the one before.
constexpr double kMeaninglessTurn_rad = 0.25;

constexpr gpu::BindingKind kStorage{vk::DescriptorType::eStorageBuffer, vk::ShaderStageFlagBits::eCompute};

/// Set 0 of shade.comp: the last bindings only where masks are carried over, and things move meanwhile.
std::vector<gpu::BindingKind> shading_set(const ShadingBytes& bytes) {
  using Type = vk::DescriptorType;
  const auto compute = vk::ShaderStageFlagBits::eCompute;
  const gpu::BindingKind uniform{Type::eUniformBuffer, compute},
      texture{Type::eCombinedImageSampler, compute};
  std::vector<gpu::BindingKind> kinds{uniform, uniform, kStorage, kStorage,
                                      texture, texture, texture,  {Type::eStorageImage, compute}};
  if (bytes.lists > 0) kinds.push_back(kStorage);
  if (bytes.motions > 0) kinds.insert(kinds.end(), 2, kStorage);
  return kinds;
}

enum class Shadows : std::uint8_t { Masks, Maps };

std::span<const std::uint32_t> shader_of(std::uint32_t pass, Shadows shadows, bool motion,
                                         ShadingPass::Report report) {
  const bool tells = report == ShadingPass::Report::On;
  using Words = std::span<const std::uint32_t>;
  if (shadows == Shadows::Maps) return tells ? Words(shade_maps_report_comp_spv) : shade_maps_comp_spv;
  if (pass == FARSHADE_PASS_DIRECT)
    return tells ? Words(shade_direct_report_comp_spv) : shade_direct_comp_spv;
  if (motion) return tells ? Words(shade_motion_report_comp_spv) : shade_motion_comp_spv;
  return tells ? Words(shade_report_comp_spv) : shade_comp_spv;
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

ShadingPass::ShadingPass(const gpu::Device& device, const DrawPlan& plan, const GBufferPass& gbuffer,
                         const DepthRing& ring, const gpu::Buffer& frame, const MotionModel& motion,
                         Extent size, Extent traced_size)
    : device_(device),
      plan_(plan),
      ring_(ring),
      frame_buffer_(frame),
      size_(size),
      bytes_(shading_bytes(plan, size, traced_size)),
      motion_count_(motion.slot_count()) {
  make_buffers(motion);
  make_sets(gbuffer);
  if (!plan.builds_late) make_all_pipelines();
}

void ShadingPass::make_buffers(const MotionModel& motion) {
  const auto storage = vk::BufferUsageFlagBits::eStorageBuffer;
  const auto mapped = [&](std::size_t bytes, const char* name, gpu::Use use) {
    return gpu::make_mapped_buffer(device_, bytes, storage, name, use);
  };
  light_buffer_ = gpu::make_mapped_buffer(device_, bytes_.lights, vk::BufferUsageFlagBits::eUniformBuffer,
                                          "lights", gpu::Use::Frame);
  const std::size_t places = most_masks(plan_) * kEyes;
  mask_buffer_ = mapped(places * bytes_.mask, "masks", gpu::Use::Masks);
  known_buffer_ = mapped(places * bytes_.known, "known tiles", gpu::Use::Masks);
  if (bytes_.motions > 0) {
    motion_slots_ = mapped(bytes_.slots, "motion slots", gpu::Use::Motion);
    std::ranges::copy(motion.slots(), motion_slots_.as<std::uint32_t>().begin());
    motion_buffer_ = mapped(bytes_.motions, "motions", gpu::Use::Motion);
  }
  if (bytes_.lists > 0)
    hard_buffer_ = gpu::make_device_buffer(
        device_, bytes_.lists,
        storage | vk::BufferUsageFlagBits::eTransferDst | vk::BufferUsageFlagBits::eIndirectBuffer,
        "hard pixels", gpu::Use::Lists);
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

void ShadingPass::make_sets(const GBufferPass& gbuffer) {
  nearest_ = device_.logical.createSampler({});
  bindings_ = gpu::make_bindings(device_, shading_set(bytes_), "shading");
  std::uint32_t binding = 0;
  gpu::bind_buffer(device_, bindings_, binding++, frame_buffer_);
  for (const gpu::Buffer* buffer : {&light_buffer_, &mask_buffer_, &known_buffer_})
    gpu::bind_buffer(device_, bindings_, binding++, *buffer);
  for (const gpu::Image* image : {&ring_.image(), &gbuffer.base_colors(), &gbuffer.surfaces()})
    gpu::bind_image(device_, bindings_, binding++, {*image->view, Layout::eShaderReadOnlyOptimal, *nearest_});
  gpu::bind_image(device_, bindings_, binding++, {*shown_.view, Layout::eGeneral, nullptr});
  for (const gpu::Buffer* buffer : {&hard_buffer_, &motion_slots_, &motion_buffer_})
    if (buffer->bytes > 0) gpu::bind_buffer(device_, bindings_, binding++, *buffer);
  check_eq(std::size_t{binding}, bindings_.kinds.size(), "bindings of the shading pass");
}

/// The device slot that holds the mask; written only if it does not hold these bits yet.
std::size_t ShadingPass::make_resident(const TracedMask& mask) {
  const auto places = std::span(resident_).first(most_masks(plan_));
  auto slot = std::ranges::find(places, std::optional(mask.frame), &Resident::frame);
  if (slot == places.end()) slot = std::ranges::min_element(places, {}, &Resident::used);
  const auto index = static_cast<std::size_t>(slot - places.begin());
  if (slot->frame != mask.frame || slot->content != mask.content)
    *slot = {mask.frame, mask.content, draws_, upload(index, mask)};
  slot->used = draws_;
  return index;
}

/// True if every tile is known. A tile counts as known once all its planes are.
bool ShadingPass::upload(std::size_t slot, const TracedMask& mask) const {
  bool whole = true;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const std::size_t place = slot * kEyes + eye;
    const EyeMask& bits = mask.masks[eye];
    check(bits.layout() == plan_.mask, "a mask lies as planned");
    const std::size_t bytes = mask_bytes(bits.size(), device_mask(plan_));
    check(bytes <= bytes_.mask, "a mask fits its place");
    const auto there = mask_buffer_.as<std::byte>().subspan(place * bytes_.mask, bytes);
    if (carries_masks(plan_)) {
      copy_with_edges(bits, there);
    } else {
      std::ranges::copy(bits.bytes(), there.begin());
    }
    const std::size_t known_words = bytes_.known / 4;
    const auto known = known_buffer_.as<std::uint32_t>().subspan(place * known_words, known_words);
    std::fill(known.begin(), known.end(), 0u);
    for (std::size_t tile = 0; tile < mask.known_tiles[eye].size(); ++tile) {
      const bool is_known = mask.known_tiles[eye][tile] == all_planes_known(plan_.mask);
      known[tile / 32] |= static_cast<std::uint32_t>(is_known) << tile % 32;
      whole &= is_known;
    }
  }
  return whole;
}

/// Each mask as traced for the eye itself and for the other.
void ShadingPass::list_sources(const StereoView& views, std::span<const DatedMask> masks,
                               gpu::FrameData& frame) {
  frame.counts.x = narrow<std::uint32_t>(masks.size());
  whole_ = true;
  for (std::size_t m = 0; m < masks.size(); ++m) {
    const TracedMask& mask = masks[m].mask;
    const std::size_t slot = make_resident(mask);
    whole_ &= resident_[slot].whole;
    const std::size_t layer = ring_.has(mask.frame) ? ring_.layer_of(mask.frame) : 0;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::size_t traced = 0; traced < kEyes; ++traced) {
        if (traced != eye && !other_eye_) continue;
        const std::size_t i = m + (traced == eye ? 0 : kMaxMasks);
        gpu::SourceData& source = frame.sources[eye * FARSHADE_MAX_SOURCES + i];
        source = source_data(pose_delta(views[eye], {}, mask.views[traced], {}), mask.views[traced]);
        source.place = {layer + traced, (slot * kEyes + traced) * bytes_.mask / 4,
                        (slot * kEyes + traced) * bytes_.known / 4, 0};
      }
  }
}

/// How points on moving instances are carried back to where they were for `masks[mask]`.
void ShadingPass::tell_carries(const StereoView& views, std::span<const DatedMask> masks, std::size_t mask) {
  const auto has_moved = [&](const DatedMask& dated, std::size_t slot) {
    return slot < dated.motion.then_from_now.size() && dated.motion.then_from_now[slot];
  };
  for (std::size_t slot = 0; slot < motion_count_; ++slot)
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      glm::mat4& carry = motion_buffer_.as<glm::mat4>()[(slot * kMaxMasks + mask) * kEyes + eye];
      carry = glm::mat4(1.0f);
      const Rigid<Stage, Eye>& stage_from_eye = views[eye].stage_from_eye;
      if (has_moved(masks[mask], slot))
        carry = glm::mat4(matrix(inverse(stage_from_eye)) * *masks[mask].motion.then_from_now[slot] *
                          matrix(stage_from_eye));
      const auto since = mask == 0 ? masks.first(1) : masks.subspan(1);
      const bool moved =
          std::ranges::any_of(since, [&](const DatedMask& dated) { return has_moved(dated, slot); });
      carry[0][3] = moved ? 1.0f : 0.0f;
    }
}

/// What `masks`, the newest (since = 0) or all older ones (1), may no longer know. True if that is anything.
bool ShadingPass::tell_stale(const StereoView& views, std::span<const DatedMask> masks, std::size_t since,
                             gpu::FrameData& frame) {
  std::bitset<kMaxLights> lights, changed;
  std::vector<Sphere> moved;
  for (const DatedMask& dated : masks) {
    lights |= dated.motion.stale_lights;
    changed |= dated.motion.changed_lights;
    for (const Sphere& sphere : dated.motion.moved) add_sphere(sphere, moved);
  }
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const auto word = static_cast<int>(i / 32 % 4);
    if (lights[i]) frame.stale_lights[since * 2 + i / 128][word] |= 1u << i % 32;
    if (changed[i]) frame.changed_lights[i / 128][word] |= 1u << i % 32;
  }
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t i = 0; i < kMostSpheres; ++i) {
      glm::vec4& sphere = frame.moved[(since * kEyes + eye) * kMostSpheres + i];
      sphere = {0, 0, 0, -1};
      if (i < moved.size())
        sphere = glm::vec4(moved[i].centre.v - views[eye].stage_from_eye.translation,
                           moved[i].radius * moved[i].radius);
    }
  return lights.any() || !moved.empty();
}

void ShadingPass::prepare(std::uint32_t shown_layer, const StereoView& views, const LightSet& lights,
                          std::span<const DatedMask> masks, const CarryOver& carry_over) {
  check(masks.size() <= most_masks(plan_), "no more masks than the device holds");
  check_eq(lights.lights.size(), std::size_t{plan_.mask.lights}, "lights of the scene and of the plan");
  ++draws_;
  carry_over_ = carry_over;
  if (!carries_masks(plan_)) carry_over_.lookup = Lookup::Direct;
  other_eye_ = plan_.other_eye && carry_over.eyes == Eyes::Both &&
               (!plan_.builds_late || (!masks.empty() && masks[0].mask.views[0] != masks[0].mask.views[1]));
  gpu::FrameData frame{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) frame.eye[eye] = eye_data(views[eye]);
  list_sources(views, masks, frame);
  masks_ = masks.size();
  const std::size_t newest = std::min(masks_, std::size_t{1});
  moved_since_newest_ = tell_stale(views, masks.first(newest), 0, frame);
  moved_ = tell_stale(views, masks.subspan(newest), 1, frame) || moved_since_newest_;
  if (!plan_.builds_late) fit_every_frame();
  for (std::size_t m = 0; m < masks.size() && moved_; ++m) tell_carries(views, masks, m);
  frame.counts.y = shown_layer;
  if (!masks.empty()) {
    const PoseDelta delta = pose_delta(views[0], {}, masks[0].mask.views[0], {});
    frame.counts.z = delta.angle_rad < kMeaninglessTurn_rad;
    frame.direct = pixel_map(views[0], masks[0].mask.views[0]);
  }
  maps_ = nullptr;
  tell_frame(views, lights, frame);
}

void ShadingPass::tell_frame(const StereoView& views, const LightSet& lights, const gpu::FrameData& frame) {
  frame_buffer_.as<gpu::FrameData>()[0] = frame;
  for (std::size_t i = 0; i < lights.lights.size(); ++i) {
    light_buffer_.as<gpu::LightData>()[i] = light_data(views, lights.lights[i]);
    off_[i] = !lights.lights[i].on;
  }
}

/// As pipelines that are made before any frame is known must: nothing is taken for granted.
void ShadingPass::fit_every_frame() {
  whole_ = false;
  moved_ = moved_since_newest_ = true;
}

vk::raii::Pipeline ShadingPass::make_pipeline(const Key& key) {
  const Shadows shadows = key.map_side_px > 0 ? Shadows::Maps : Shadows::Masks;
  const vk::raii::ShaderModule shader =
      gpu::make_shader(device_, shader_of(key.pass, shadows, motion_count_ > 0, key.report), "shade.comp");
  const std::uint32_t lights = plan_.mask.lights;
  const gpu::Specialization constants(
      {lights, device_mask(plan_).word_bytes(), key.pass, key.carry_over.eyes == Eyes::Both,
       plan_.ranges_and_cones, std::bit_cast<std::uint32_t>(static_cast<float>(kNearPlane_m)),
       std::bit_cast<std::uint32_t>(kUnknownVisibility), key.eye, key.whole, key.moved,
       key.carry_over.gaps == Gaps::Neighbours, key.carry_over.edges == Edges::Filtered,
       std::bit_cast<std::uint32_t>(kSharpness), key.moved_since_newest, first_edge_bit(lights),
       key.map_side_px, key.pcf_radius});
  return gpu::make_compute_pipeline(device_, need_layout(key.report), shader, constants, "shade");
}

const vk::raii::Pipeline& ShadingPass::need_pipeline(const Key& key) {
  auto found = pipelines_.find(key);
  if (found == pipelines_.end()) found = pipelines_.emplace(key, make_pipeline(key)).first;
  return found->second;
}

/// Those of the default way to carry masks over.
void ShadingPass::make_all_pipelines() {
  fit_every_frame();
  other_eye_ = plan_.other_eye;
  const std::uint32_t last = carries_masks(plan_) ? FARSHADE_PASS_MOVING : FARSHADE_PASS_DIRECT;
  for (std::uint32_t pass = FARSHADE_PASS_DIRECT; pass <= last; ++pass)
    for (std::uint32_t eye = 0; eye < kEyes; ++eye) need_pipeline(key_of(pass, Report::Off, eye));
}

/// What a pass does not look at is the same in all of its keys, so that it is not compiled again for nothing.
ShadingPass::Key ShadingPass::key_of(std::uint32_t pass, Report report, std::uint32_t eye) const {
  const bool second_look = pass >= FARSHADE_PASS_HARD, direct = pass == FARSHADE_PASS_DIRECT;
  CarryOver carry_over = direct ? CarryOver{} : carry_over_;
  carry_over.lookup = Lookup::Reproject;
  carry_over.eyes = second_look && other_eye_ ? Eyes::Both : Eyes::This;
  if (!second_look) carry_over.gaps = Gaps::Neighbours;
  return {.pass = pass,
          .carry_over = carry_over,
          .report = report,
          .whole = whole_ && !second_look,
          .moved = moved_ && !direct,
          .moved_since_newest = moved_since_newest_ && !direct,
          .eye = eye,
          .map_side_px = maps_ != nullptr ? maps_->wish().side_px : 0,
          .pcf_radius = maps_ != nullptr ? maps_->wish().pcf_radius : 0};
}

/// The report is large and most sessions never ask for it.
void ShadingPass::make_report_buffer() {
  if (report_buffer_.bytes > 0) return;
  report_buffer_ = gpu::make_readback_buffer(device_, bytes_.report, "report", gpu::Use::Report);
  report_bindings_ = gpu::make_bindings(device_, {kStorage}, "report");
  gpu::bind_buffer(device_, report_bindings_, 0, report_buffer_);
}

void ShadingPass::shade_all(const vk::raii::CommandBuffer& commands, std::uint32_t pass, Report report) {
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *need_pipeline(key_of(pass, report, eye)));
    commands.dispatch((size_.width + kGroup_px - 1) / kGroup_px, size_.height, 1);
  }
}

void ShadingPass::shade_listed(const vk::raii::CommandBuffer& commands, std::uint32_t pass, Report report) {
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *need_pipeline(key_of(pass, report, eye)));
    const std::size_t list = eye * 2 + (pass == FARSHADE_PASS_MOVING ? 1 : 0);
    commands.dispatchIndirect(*hard_buffer_.buffer, list * sizeof(glm::uvec4));
  }
}

void ShadingPass::shade_carried_over(const vk::raii::CommandBuffer& commands, Report report) {
  std::array<glm::uvec4, 2 * kEyes> empty_lists;
  empty_lists.fill({0, 1, 1, 0});
  commands.updateBuffer<glm::uvec4>(*hard_buffer_.buffer, 0, empty_lists);
  barrier(commands, At::eTransfer, Access::eTransferWrite, At::eComputeShader,
          Access::eShaderRead | Access::eShaderWrite);
  shade_all(commands, FARSHADE_PASS_EASY, report);
  barrier(commands, At::eComputeShader, Access::eShaderWrite, At::eComputeShader | At::eDrawIndirect,
          Access::eShaderRead | Access::eShaderWrite | Access::eIndirectCommandRead);
  shade_listed(commands, FARSHADE_PASS_HARD, report);
  if (moved_ && motion_count_ > 0) shade_listed(commands, FARSHADE_PASS_MOVING, report);
}

void ShadingPass::record(const vk::raii::CommandBuffer& commands, Report report) {
  if (report == Report::On) make_report_buffer();
  bind_sets(commands, report);
  gpu::transition(commands, shown_, Layout::eUndefined, Layout::eGeneral);
  if (carry_over_.lookup == Lookup::Direct || masks_ == 0) {
    shade_all(commands, FARSHADE_PASS_DIRECT, report);
  } else {
    shade_carried_over(commands, report);
  }
  barrier(commands, At::eComputeShader, Access::eShaderWrite, At::eHost | At::eTransfer,
          Access::eHostRead | Access::eTransferRead);
}

}  // namespace farshade
