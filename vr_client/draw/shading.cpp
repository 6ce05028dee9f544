#include "vr_client/draw/shading.h"

#include <algorithm>
#include <bit>

#include "shaders/shade.comp.spv.h"
#include "stereo/frame/tiles.h"
#include "vr_client/draw/mask_edges.h"

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

std::vector<gpu::BindingKind> shading_set() {
  using Type = vk::DescriptorType;
  const auto compute = vk::ShaderStageFlagBits::eCompute;
  const gpu::BindingKind uniform{Type::eUniformBuffer, compute}, buffer{Type::eStorageBuffer, compute},
      texture{Type::eCombinedImageSampler, compute};
  return {uniform, uniform, buffer, buffer, texture, texture, texture, {Type::eStorageImage, compute},
          buffer,  buffer,  buffer, buffer};
}

/// What one pixel's report is made of, in words, as shade.comp writes it.
struct ReportLayout {
  explicit ReportLayout(MaskLayout mask)
      : visibility(3),
        unknown(3 + (mask.lights + 3) / 4),
        stale(unknown + planes(mask)),
        beside(stale + planes(mask)),
        words(beside + planes(mask)) {}

  std::size_t visibility, unknown, stale, beside, words;

 private:
  /// Without lights shade.comp has no planes.
  static std::size_t planes(MaskLayout mask) { return (mask.lights + 31) / 32; }
};

constexpr std::size_t words(std::size_t bytes) {
  return (bytes + 3) / 4;
}

}  // namespace

ShadingPass::ShadingPass(const gpu::Device& device, const GBufferPass& gbuffer, const DepthRing& ring,
                         const gpu::Buffer& frame, const MotionModel& motion, Extent size, Extent traced_size,
                         MaskLayout mask)
    : device_(device),
      ring_(ring),
      frame_buffer_(frame),
      size_(size),
      mask_(mask),
      mask_words_(words(mask_bytes(traced_size, with_edge_bits(mask_)))),
      known_words_((TileGrid{traced_size}.count() + 31) / 32),
      motion_count_(motion.slot_count()) {
  const auto storage = vk::BufferUsageFlagBits::eStorageBuffer;
  const auto mapped = [&](std::size_t bytes, const char* name) {
    return gpu::make_mapped_buffer(device, bytes, storage, name);
  };
  light_buffer_ = gpu::make_mapped_buffer(device, (mask.lights + 1) * sizeof(gpu::LightData),
                                          vk::BufferUsageFlagBits::eUniformBuffer, "lights");
  mask_buffer_ = mapped(kMaxMasks * kEyes * mask_words_ * 4, "masks");
  known_buffer_ = mapped(kMaxMasks * kEyes * known_words_ * 4, "known tiles");
  motion_slots_ = mapped(motion.slots().size() * 4, "motion slots");
  std::ranges::copy(motion.slots(), motion_slots_.as<std::uint32_t>().begin());
  motion_buffer_ = mapped(motion_count_ * kMaxMasks * kEyes * sizeof(glm::mat4), "motions");
  hard_buffer_ = gpu::make_device_buffer(
      device, 2 * kEyes * sizeof(glm::uvec4) + kEyes * size.pixels() * sizeof(std::uint32_t),
      storage | vk::BufferUsageFlagBits::eTransferDst | vk::BufferUsageFlagBits::eIndirectBuffer,
      "hard pixels");
  shown_ = gpu::make_image(device,
                           {.size = size,
                            .layers = kEyes,
                            .format = vk::Format::eR8G8B8A8Unorm,
                            .usage = vk::ImageUsageFlagBits::eStorage | vk::ImageUsageFlagBits::eTransferSrc |
                                     vk::ImageUsageFlagBits::eSampled},
                           "shown");
  report_buffer_ = gpu::make_readback_buffer(device, 0, "report, none yet");
  nearest_ = device.logical.createSampler({});
  bindings_ = gpu::make_bindings(device, shading_set(), "shading");
  const std::array<std::pair<std::uint32_t, const gpu::Buffer*>, 8> buffers{{{0, &frame},
                                                                             {1, &light_buffer_},
                                                                             {2, &mask_buffer_},
                                                                             {3, &known_buffer_},
                                                                             {8, &report_buffer_},
                                                                             {9, &motion_slots_},
                                                                             {10, &motion_buffer_},
                                                                             {11, &hard_buffer_}}};
  for (const auto& [binding, buffer] : buffers) gpu::bind_buffer(device, bindings_, binding, *buffer);
  std::uint32_t binding = 4;
  for (const gpu::Image* image : {&ring.image(), &gbuffer.base_colors(), &gbuffer.surfaces()})
    gpu::bind_image(device, bindings_, binding++, {*image->view, Layout::eShaderReadOnlyOptimal, *nearest_});
  gpu::bind_image(device, bindings_, 7, {*shown_.view, Layout::eGeneral, nullptr});
  const vk::DescriptorSetLayout set = *bindings_.layout;
  layout_ = device.logical.createPipelineLayout({.setLayoutCount = 1, .pSetLayouts = &set});
  shader_ = gpu::make_shader(device, shade_comp_spv, "shade.comp");
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, shown_, Layout::eUndefined, Layout::eGeneral);
  });
}

/// The device slot that holds the mask; written only if it does not hold these bits yet.
std::size_t ShadingPass::make_resident(const MaskInHand& mask) {
  auto slot = std::find_if(resident_.begin(), resident_.end(),
                           [&](const Resident& resident) { return resident.frame == mask.frame; });
  if (slot == resident_.end())
    slot = std::min_element(resident_.begin(), resident_.end(),
                            [](const Resident& a, const Resident& b) { return a.used < b.used; });
  const auto index = static_cast<std::size_t>(slot - resident_.begin());
  if (slot->frame != mask.frame || slot->content != mask.content)
    *slot = {mask.frame, mask.content, draws_, upload(index, mask)};
  slot->used = draws_;
  return index;
}

/// True if every tile is known. A tile counts as known once all its planes are.
bool ShadingPass::upload(std::size_t slot, const MaskInHand& mask) const {
  bool whole = true;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const std::size_t place = slot * kEyes + eye;
    const std::size_t bytes = mask_bytes(mask.masks[eye].size(), with_edge_bits(mask_));
    check(mask.masks[eye].layout() == mask_ && words(bytes) <= mask_words_, "a mask fits its place");
    copy_with_edges(mask.masks[eye], mask_buffer_.as<std::byte>().subspan(place * mask_words_ * 4, bytes));
    const auto known = known_buffer_.as<std::uint32_t>().subspan(place * known_words_, known_words_);
    std::fill(known.begin(), known.end(), 0u);
    for (std::size_t tile = 0; tile < mask.known_tiles[eye].size(); ++tile) {
      const bool is_known = mask.known_tiles[eye][tile] == all_planes_known(mask_);
      known[tile / 32] |= static_cast<std::uint32_t>(is_known) << tile % 32;
      whole &= is_known;
    }
  }
  return whole;
}

/// Each mask as traced for the eye itself and for the other.
void ShadingPass::list_sources(const StereoView& views, std::span<const DatedMask> masks,
                               gpu::FrameData& frame) {
  const bool both =
      carry_over_.eyes == Eyes::Both && !masks.empty() && masks[0].mask.views[0] != masks[0].mask.views[1];
  frame.counts.x = narrow<std::uint32_t>(masks.size());
  frame.counts.z = both;
  whole_ = true;
  for (std::size_t m = 0; m < masks.size(); ++m) {
    const MaskInHand& mask = masks[m].mask;
    const std::size_t slot = make_resident(mask);
    whole_ &= resident_[slot].whole;
    const std::size_t layer = ring_.has(mask.frame) ? ring_.layer_of(mask.frame) : 0;
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for (std::size_t traced = 0; traced < kEyes; ++traced) {
        const std::size_t i = m + (traced == eye ? 0 : kMaxMasks);
        gpu::SourceData& source = frame.sources[eye * FARSHADE_MAX_SOURCES + i];
        source = source_data(pose_delta(views[eye], {}, mask.views[traced], {}), mask.views[traced]);
        source.place = {layer + traced, (slot * kEyes + traced) * mask_words_,
                        (slot * kEyes + traced) * known_words_, 0};
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
  check(masks.size() <= kMaxMasks, "no more masks than the device ring holds");
  check_eq(lights.lights.size(), std::size_t{mask_.lights}, "lights of the scene and of the pass");
  ++draws_;
  carry_over_ = carry_over;
  gpu::FrameData frame{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) frame.eye[eye] = eye_data(views[eye]);
  list_sources(views, masks, frame);
  masks_ = masks.size();
  const std::size_t newest = std::min(masks_, std::size_t{1});
  moved_since_newest_ = tell_stale(views, masks.first(newest), 0, frame);
  moved_ = tell_stale(views, masks.subspan(newest), 1, frame) || moved_since_newest_;
  for (std::size_t m = 0; m < masks.size() && moved_; ++m) tell_carries(views, masks, m);
  frame.counts.y = shown_layer;
  if (!masks.empty()) {
    const PoseDelta delta = pose_delta(views[0], {}, masks[0].mask.views[0], {});
    frame.counts.w = delta.angle_rad < kMeaninglessTurn_rad;
    frame.direct = pixel_map(views[0], masks[0].mask.views[0]);
  }
  frame_buffer_.as<gpu::FrameData>()[0] = frame;
  const auto light_data_of = light_buffer_.as<gpu::LightData>();
  ranges_and_cones_ = false;
  for (std::size_t i = 0; i < lights.lights.size(); ++i) {
    light_data_of[i] = light_data(views, lights.lights[i]);
    off_[i] = !lights.lights[i].on;
    ranges_and_cones_ |= lights.lights[i].kind == LightKind::Spot || lights.lights[i].range_m > 0;
  }
}

const vk::raii::Pipeline& ShadingPass::pipeline(const Key& key) {
  auto found = pipelines_.find(key);
  if (found == pipelines_.end()) {
    const gpu::Specialization constants(
        {mask_.lights, with_edge_bits(mask_).word_bytes(), key.pass, key.report == Report::On,
         key.ranges_and_cones, std::bit_cast<std::uint32_t>(static_cast<float>(kNearPlane_m)),
         std::bit_cast<std::uint32_t>(kUnknownVisibility), key.eye, key.whole, key.moved,
         key.carry_over.gaps == Gaps::Neighbours, key.carry_over.edges == Edges::Filtered,
         std::bit_cast<std::uint32_t>(kSharpness), key.moved_since_newest, first_edge_bit(mask_.lights)});
    found = pipelines_.emplace(key, gpu::make_compute_pipeline(device_, layout_, shader_, constants, "shade"))
                .first;
  }
  return found->second;
}

/// What a pass does not look at is the same in all of its keys, so that it is not compiled again for nothing.
ShadingPass::Key ShadingPass::key_of(std::uint32_t pass, Report report, std::uint32_t eye) const {
  const bool second_look = pass >= FARSHADE_PASS_HARD, direct = pass == FARSHADE_PASS_DIRECT;
  return {.pass = pass,
          .carry_over = direct ? CarryOver{} : carry_over_,
          .report = report,
          .ranges_and_cones = ranges_and_cones_,
          .whole = whole_ && !second_look,
          .moved = moved_ && !direct,
          .moved_since_newest = moved_since_newest_ && !direct,
          .eye = eye};
}

/// The report is large and most sessions never ask for it.
void ShadingPass::make_report_buffer() {
  const std::size_t bytes = kEyes * size_.pixels() * ReportLayout(mask_).words * 4;
  if (report_buffer_.bytes >= bytes) return;
  report_buffer_ = gpu::make_readback_buffer(device_, bytes, "report");
  gpu::bind_buffer(device_, bindings_, 8, report_buffer_);
}

void ShadingPass::record(const vk::raii::CommandBuffer& commands, Report report) {
  using At = vk::PipelineStageFlagBits2;
  using Access = vk::AccessFlagBits2;
  const auto barrier = [&](vk::PipelineStageFlags2 from, vk::AccessFlags2 written, vk::PipelineStageFlags2 to,
                           vk::AccessFlags2 read) {
    const vk::MemoryBarrier2 memory{
        .srcStageMask = from, .srcAccessMask = written, .dstStageMask = to, .dstAccessMask = read};
    commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &memory});
  };
  const auto bind = [&](std::uint32_t pass, std::uint32_t eye) {
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline(key_of(pass, report, eye)));
  };
  const auto shade_all = [&](std::uint32_t pass) {
    for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
      bind(pass, eye);
      commands.dispatch((size_.width + kGroup_px - 1) / kGroup_px, size_.height, 1);
    }
  };
  const auto shade_listed = [&](std::uint32_t pass) {
    for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
      bind(pass, eye);
      const std::size_t list = eye * 2 + (pass == FARSHADE_PASS_MOVING ? 1 : 0);
      commands.dispatchIndirect(*hard_buffer_.buffer, list * sizeof(glm::uvec4));
    }
  };
  if (report == Report::On) make_report_buffer();
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *bindings_.set, {});
  gpu::transition(commands, shown_, Layout::eUndefined, Layout::eGeneral);
  if (carry_over_.lookup == Lookup::Direct || masks_ == 0) {
    shade_all(FARSHADE_PASS_DIRECT);
  } else {
    const std::array<glm::uvec4, 2 * kEyes> empty_lists = [] {
      std::array<glm::uvec4, 2 * kEyes> lists;
      lists.fill({0, 1, 1, 0});
      return lists;
    }();
    commands.updateBuffer<glm::uvec4>(*hard_buffer_.buffer, 0, empty_lists);
    barrier(At::eTransfer, Access::eTransferWrite, At::eComputeShader,
            Access::eShaderRead | Access::eShaderWrite);
    shade_all(FARSHADE_PASS_EASY);
    barrier(At::eComputeShader, Access::eShaderWrite, At::eComputeShader | At::eDrawIndirect,
            Access::eShaderRead | Access::eShaderWrite | Access::eIndirectCommandRead);
    shade_listed(FARSHADE_PASS_HARD);
    if (moved_) shade_listed(FARSHADE_PASS_MOVING);
  }
  barrier(At::eComputeShader, Access::eShaderWrite, At::eHost | At::eTransfer,
          Access::eHostRead | Access::eTransferRead);
}

ShownReport ShadingPass::report(Side side) const {
  const ReportLayout layout(mask_);
  const std::size_t pixels = size_.pixels(), lights = mask_.lights, planes = (lights + 31) / 32;
  ShownReport result{.mask = EyeMask(size_, mask_),
                     .sources = std::vector<std::uint8_t>(pixels),
                     .positions = std::vector<std::array<float, 2>>(pixels),
                     .visibility = std::vector<std::uint8_t>(pixels * lights),
                     .unknown = std::vector<std::uint32_t>(pixels * planes),
                     .stale = std::vector<std::uint32_t>(pixels * planes),
                     .beside = std::vector<std::uint32_t>(pixels * planes),
                     .rays = std::vector<std::uint16_t>(pixels)};
  auto row = report_buffer_.as<const std::uint32_t>().subspan(index_of(side) * pixels * layout.words);
  for (std::size_t at = 0; at < pixels; ++at, row = row.subspan(layout.words)) {
    result.sources[at] = static_cast<std::uint8_t>(row[0]);
    result.rays[at] = static_cast<std::uint16_t>(row[0] >> 16);
    result.positions[at] = {std::bit_cast<float>(row[1]), std::bit_cast<float>(row[2])};
    for (std::size_t i = 0; i < lights; ++i)
      result.visibility[at * lights + i] =
          off_[i] ? std::uint8_t{0}
                  : static_cast<std::uint8_t>(row[layout.visibility + i / 4] >> (i % 4 * 8));
    for (std::uint32_t plane = 0; plane < planes; ++plane) {
      std::uint32_t bits = 0, on = 0;
      for (std::size_t i = plane * 32; i < std::min<std::size_t>(lights, plane * 32 + 32); ++i) {
        on |= std::uint32_t{!off_[i]} << i % 32;
        bits |= std::uint32_t{result.visibility[at * lights + i] >= 128} << i % 32;
      }
      result.mask.set_word(static_cast<std::uint32_t>(at % size_.width),
                           static_cast<std::uint32_t>(at / size_.width), plane, bits);
      result.unknown[at * planes + plane] = row[layout.unknown + plane] & on;
      result.stale[at * planes + plane] = row[layout.stale + plane] & on;
      result.beside[at * planes + plane] = row[layout.beside + plane] & on;
    }
  }
  return result;
}

}  // namespace farshade
