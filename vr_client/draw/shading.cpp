#include "vr_client/draw/shading.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "shaders/shade.comp.spv.h"
#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

constexpr std::uint32_t kGroup_px = 64;  // as in shade.comp
static_assert(kTileSide_px == FARSHADE_TILE_PX);

std::vector<gpu::BindingKind> shading_set() {
  using Type = vk::DescriptorType;
  const auto compute = vk::ShaderStageFlagBits::eCompute;
  const gpu::BindingKind uniform{Type::eUniformBuffer, compute}, buffer{Type::eStorageBuffer, compute},
      texture{Type::eCombinedImageSampler, compute};
  return {uniform, uniform, buffer, buffer, texture, texture, texture, {Type::eStorageImage, compute},
          buffer,  buffer};
}

}  // namespace

ShadingPass::ShadingPass(const gpu::Device& device, const GBufferPass& gbuffer, Extent size,
                         std::uint32_t lights)
    : device_(device),
      gbuffer_(gbuffer),
      size_(size),
      mask_{lights},
      mask_words_((size.pixels() * mask_.planes() * mask_.word_bytes() + 3) / 4),
      known_words_((TileGrid{size}.count() + 31) / 32) {
  const auto storage = vk::BufferUsageFlagBits::eStorageBuffer;
  const auto words = [](std::size_t count) { return count * sizeof(std::uint32_t); };
  light_buffer_ = gpu::make_mapped_buffer(device, (lights + 1) * sizeof(gpu::LightData),
                                          vk::BufferUsageFlagBits::eUniformBuffer, "lights");
  mask_buffer_ = gpu::make_mapped_buffer(device, words(kMaxMasks * kEyes * mask_words_), storage, "masks");
  known_buffer_ =
      gpu::make_mapped_buffer(device, words(kMaxMasks * kEyes * known_words_), storage, "known tiles");
  bits_buffer_ =
      gpu::make_readback_buffer(device, words(kEyes * size.pixels() * mask_.planes()), "shown bits");
  source_buffer_ = gpu::make_readback_buffer(device, words(kEyes * size.pixels()), "shown sources");
  shown_ = gpu::make_image(device,
                           {.size = size,
                            .layers = kEyes,
                            .format = vk::Format::eR8G8B8A8Unorm,
                            .usage = vk::ImageUsageFlagBits::eStorage | vk::ImageUsageFlagBits::eTransferSrc},
                           "shown");
  nearest_ = device.logical.createSampler({});
  bindings_ = gpu::make_bindings(device, shading_set(), "shading");
  gpu::bind_buffer(device, bindings_, 0, gbuffer.frame_buffer());
  gpu::bind_buffer(device, bindings_, 1, light_buffer_);
  gpu::bind_buffer(device, bindings_, 2, mask_buffer_);
  gpu::bind_buffer(device, bindings_, 3, known_buffer_);
  std::uint32_t binding = 4;
  for (const gpu::Image* image : {&gbuffer.depth_ring(), &gbuffer.base_colors(), &gbuffer.surfaces()})
    gpu::bind_image(device, bindings_, binding++, {*image->view, Layout::eShaderReadOnlyOptimal, *nearest_});
  gpu::bind_image(device, bindings_, 7, {*shown_.view, Layout::eGeneral, nullptr});
  gpu::bind_buffer(device, bindings_, 8, bits_buffer_);
  gpu::bind_buffer(device, bindings_, 9, source_buffer_);
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
    const std::span<const std::byte> bits = mask.masks[eye].bytes();
    check(mask.masks[eye].size() == size_ && mask.masks[eye].layout() == mask_, "a mask has the shown shape");
    std::memcpy(mask_buffer_.mapped + (slot * kEyes + eye) * mask_words_ * 4, bits.data(), bits.size());
    const auto known =
        known_buffer_.as<std::uint32_t>().subspan((slot * kEyes + eye) * known_words_, known_words_);
    std::fill(known.begin(), known.end(), 0u);
    for (std::size_t tile = 0; tile < mask.known_tiles[eye].size(); ++tile) {
      const bool is_known = mask.known_tiles[eye][tile] == all_planes_known(mask_);
      known[tile / 32] |= static_cast<std::uint32_t>(is_known) << tile % 32;
      whole &= is_known;
    }
  }
  return whole;
}

void ShadingPass::prepare(FrameId shown, const StereoView& views, const LightSet& lights,
                          std::span<const MaskInHand> masks) {
  check(masks.size() <= kMaxMasks, "no more masks than the device ring holds");
  check_eq(lights.lights.size(), std::size_t{mask_.lights}, "lights of the scene and of the pass");
  ++draws_;
  gpu::FrameData frame{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) frame.eye[eye] = eye_data(views[eye]);
  frame.counts = {masks.size(), gbuffer_.depth_layer(shown), 0, 0};
  frame.traced = {size_.width, size_.height, mask_words_, known_words_};
  whole_ = true;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    const std::size_t slot = make_resident(masks[i]);
    whole_ &= resident_[slot].whole;
    frame.masks[i] = mask_data(views, masks[i].views);
    frame.masks[i].place = {gbuffer_.depth_layer(masks[i].frame), slot * kEyes * mask_words_,
                            slot * kEyes * known_words_, 0};
  }
  gbuffer_.frame_buffer().as<gpu::FrameData>()[0] = frame;
  const auto light_data_of = light_buffer_.as<gpu::LightData>();
  ranges_and_cones_ = false;
  for (std::size_t i = 0; i < lights.lights.size(); ++i) {
    light_data_of[i] = light_data(views, lights.lights[i]);
    ranges_and_cones_ |= lights.lights[i].kind == LightKind::Spot || lights.lights[i].range_m > 0;
  }
}

const vk::raii::Pipeline& ShadingPass::pipeline(Key key) {
  auto found = pipelines_.find(key);
  if (found == pipelines_.end()) {
    const gpu::Specialization constants(
        {mask_.lights, mask_.word_bytes(), key.lookup == Lookup::Direct, key.report == Report::On,
         key.ranges_and_cones, std::bit_cast<std::uint32_t>(static_cast<float>(kNearPlane_m)),
         std::bit_cast<std::uint32_t>(kUnknownVisibility), key.eye, key.whole});
    found = pipelines_.emplace(key, gpu::make_compute_pipeline(device_, layout_, shader_, constants, "shade"))
                .first;
  }
  return found->second;
}

void ShadingPass::record(const vk::raii::CommandBuffer& commands, Lookup lookup, Report report) {
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *bindings_.set, {});
  gpu::transition(commands, shown_, Layout::eUndefined, Layout::eGeneral);
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    commands.bindPipeline(vk::PipelineBindPoint::eCompute,
                          *pipeline({lookup, report, ranges_and_cones_, whole_, eye}));
    commands.dispatch((size_.width + kGroup_px - 1) / kGroup_px, size_.height, 1);
  }
  const vk::MemoryBarrier2 to_host{
      .srcStageMask = vk::PipelineStageFlagBits2::eComputeShader,
      .srcAccessMask = vk::AccessFlagBits2::eShaderWrite,
      .dstStageMask = vk::PipelineStageFlagBits2::eHost | vk::PipelineStageFlagBits2::eTransfer,
      .dstAccessMask = vk::AccessFlagBits2::eHostRead | vk::AccessFlagBits2::eTransferRead};
  commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &to_host});
}

ShownReport ShadingPass::report(Side side) const {
  ShownReport result{EyeMask(size_, mask_.lights), std::vector<std::uint8_t>(size_.pixels())};
  const std::size_t first = index_of(side) * size_.pixels();
  const auto bits = bits_buffer_.as<const std::uint32_t>().subspan(first * mask_.planes());
  const auto sources = source_buffer_.as<const std::uint32_t>().subspan(first);
  std::size_t at = 0;
  for (std::uint32_t y = 0; y < size_.height; ++y)
    for (std::uint32_t x = 0; x < size_.width; ++x, ++at) {
      result.sources[at] = static_cast<std::uint8_t>(sources[at]);
      for (std::uint32_t plane = 0; plane < mask_.planes(); ++plane)
        result.mask.set_word(x, y, plane, bits[at * mask_.planes() + plane] & mask_.used_bits(plane));
    }
  return result;
}

}  // namespace farshade
