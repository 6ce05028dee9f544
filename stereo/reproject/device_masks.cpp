#include "stereo/reproject/device_masks.h"

#include "stereo/frame/tiles.h"
#include "stereo/plan/plan_masks.h"

namespace farshade {
namespace {

gpu::UploadBuffer make_masks(gpu::FramesInFlight& frames, std::size_t bytes, const char* name) {
  return gpu::make_upload_buffer(frames, bytes, vk::BufferUsageFlagBits::eStorageBuffer, name,
                                 gpu::Use::Masks);
}

/// Writes which blocks of each tile of an eye are known. Returns whether all are.
bool write_known(const TracedMask& mask, std::size_t eye, WriteOnly<std::uint16_t> blocks) {
  bool whole = true;
  blocks.generate([&](std::size_t tile) {
    const BlockBits known = known_blocks(mask, eye, tile);
    whole &= known == kAllBlocks;
    return known;
  });
  return whole;
}

}  // namespace

static_assert(kTileSide_px == FARSHADE_TILE_PX && kBlockSide_px == FARSHADE_BLOCK_PX);

DeviceMasks::DeviceMasks(gpu::FramesInFlight& frames, const DrawPlan& plan, const ShadingBytes& bytes)
    : plan_(plan),
      words_(make_masks(frames, bytes.all_words(plan), "masks")),
      known_(make_masks(frames, bytes.all_known(plan), "known blocks")),
      shelves_{Shelf{bytes.mask, 0, 0, MaskSlots(most_masks(plan)), std::vector<bool>(most_masks(plan))},
               Shelf{bytes.face, most_masks(plan) * kEyes * bytes.mask.words,
                     most_masks(plan) * kEyes * bytes.mask.known, MaskSlots(most_cube_mask_pairs(plan)),
                     std::vector<bool>(most_cube_mask_pairs(plan))}} {}

std::vector<DeviceMasks::Held> DeviceMasks::hold(Kind kind, std::span<const TracedMask* const> masks) {
  Shelf& shelf = shelves_[static_cast<std::size_t>(kind)];
  std::vector<MaskVersion> versions;
  for (const TracedMask* mask : masks) versions.push_back({mask->frame, mask->content});
  std::vector<Held> held;
  for (const MaskSlots::Assignment& assigned : shelf.slots.assign(versions)) {
    if (assigned.must_upload) {
      shelf.is_whole[assigned.slot] = upload(kind, assigned.slot, *masks[held.size()]);
      ++uploads_;
    }
    held.push_back({kind, assigned.slot, shelf.is_whole[assigned.slot]});
  }
  return held;
}

void DeviceMasks::set_ray_lights(const LightBits& lights) {
  if (lights != ray_lights_) shelves_[static_cast<std::size_t>(Kind::Views)].slots.clear();
  ray_lights_ = lights;
}

glm::uvec4 DeviceMasks::place(const Held& held, std::size_t eye, std::size_t layer) const {
  const Shelf& from = shelf(held.kind);
  const std::size_t at = held.slot * kEyes + eye;
  return {layer + eye, (from.words + at * from.bytes.words) / 4, (from.known + at * from.bytes.known) / 4, 0};
}

void DeviceMasks::forget() {
  for (Shelf& shelf : shelves_) shelf.slots.clear();
}

/// Copies a mask to a slot. Returns whether every block is known.
bool DeviceMasks::upload(Kind kind, std::size_t slot, const TracedMask& mask) {
  const Shelf& shelf = this->shelf(kind);
  const bool cells = kind == Kind::Views && has_cells(plan_);
  bool whole = true;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const std::size_t at = slot * kEyes + eye;
    const EyeMask& bits = mask.masks[eye];
    check(bits.layout() == plan_.mask, "a mask has the layout of the plan");
    const std::size_t bytes = device_mask_bytes(plan_, bits.size(), cells);
    check(bytes <= shelf.bytes.words, "a mask fits its slot");
    const auto there = words_.view<std::byte>(shelf.words + at * shelf.bytes.words, bytes);
    if (cells) {
      copy_with_cells(bits, ray_lights_, there);
    } else if (reprojects_masks(plan_)) {
      copy_with_edges(bits, there);
    } else {
      there.copy(bits.bytes());
    }
    const std::size_t known = (shelf.known + at * shelf.bytes.known) / sizeof(std::uint16_t);
    whole &= write_known(mask, eye, known_.view<std::uint16_t>(known, mask.received_tiles[eye].size()));
  }
  return whole;
}

}  // namespace farshade
