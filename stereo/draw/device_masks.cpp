#include "stereo/draw/device_masks.h"

#include <algorithm>

#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

gpu::Buffer mapped(const gpu::Device& device, std::size_t bytes, const char* name) {
  return gpu::make_mapped_buffer(device, bytes, vk::BufferUsageFlagBits::eStorageBuffer, name,
                                 gpu::Use::Masks);
}

/// Writes which blocks of each tile of an eye are known. Returns whether all are.
bool write_known(const TracedMask& mask, std::size_t eye, std::span<std::uint16_t> blocks) {
  bool whole = true;
  for (std::size_t tile = 0; tile < mask.known_tiles[eye].size(); ++tile) {
    blocks[tile] = known_blocks(mask, eye, tile);
    whole &= blocks[tile] == kAllBlocks;
  }
  return whole;
}

}  // namespace

static_assert(kTileSide_px == FARSHADE_TILE_PX && kBlockSide_px == FARSHADE_BLOCK_PX);

DeviceMasks::DeviceMasks(const gpu::Device& device, const DrawPlan& plan, const ShadingBytes& bytes)
    : plan_(plan),
      mask_bytes_(bytes.mask),
      known_bytes_(bytes.known),
      words_(mapped(device, most_masks(plan) * kEyes * bytes.mask, "masks")),
      known_(mapped(device, most_masks(plan) * kEyes * bytes.known, "known blocks")),
      slots_(most_masks(plan)) {}

std::vector<DeviceMasks::Held> DeviceMasks::hold(std::span<const TracedMask* const> masks) {
  std::vector<MaskVersion> versions;
  for (const TracedMask* mask : masks) versions.push_back({mask->frame, mask->content});
  std::vector<Held> held;
  for (const MaskSlots::Assignment& assigned : slots_.assign(versions)) {
    if (assigned.must_upload) {
      is_whole_[assigned.slot] = upload(assigned.slot, *masks[held.size()]);
      ++uploads_;
    }
    held.push_back({assigned.slot, is_whole_[assigned.slot]});
  }
  return held;
}

glm::uvec4 DeviceMasks::place(const Held& held, std::size_t eye, std::size_t layer) const {
  const std::size_t at = held.slot * kEyes + eye;
  return {layer + eye, at * mask_bytes_ / 4, at * known_bytes_ / 4, 0};
}

/// Copies a mask to a slot. Returns whether every block is known.
bool DeviceMasks::upload(std::size_t slot, const TracedMask& mask) const {
  bool whole = true;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const std::size_t at = slot * kEyes + eye;
    const EyeMask& bits = mask.masks[eye];
    check(bits.layout() == plan_.mask, "a mask has the layout of the plan");
    const std::size_t bytes = mask_bytes(bits.size(), device_mask(plan_));
    check(bytes <= mask_bytes_, "a mask fits its slot");
    const auto there = words_.as<std::byte>().subspan(at * mask_bytes_, bytes);
    if (carries_masks(plan_)) {
      copy_with_edges(bits, there);
    } else {
      std::ranges::copy(bits.bytes(), there.begin());
    }
    const std::size_t tiles = known_bytes_ / sizeof(std::uint16_t);
    whole &= write_known(mask, eye, known_.as<std::uint16_t>().subspan(at * tiles, tiles));
  }
  return whole;
}

}  // namespace farshade
