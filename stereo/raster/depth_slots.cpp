#include "stereo/raster/depth_slots.h"

#include <algorithm>

namespace farshade {

std::optional<std::size_t> DepthSlots::claim(FrameId frame, std::size_t slot) {
  if (slot >= slots_.size()) return std::nullopt;
  give_back(slots_[slot]);
  if (free_.empty()) free_.push_back(places_++);
  slots_[slot] = {frame, free_.back()};
  free_.pop_back();
  return slots_[slot].place;
}

void DepthSlots::release(FrameId frame) {
  for (Slot& slot : slots_)
    if (slot.frame == frame) give_back(slot);
}

std::optional<std::size_t> DepthSlots::find(FrameId frame) const {
  const auto slot = std::ranges::find(slots_, std::optional(frame), &Slot::frame);
  return slot == slots_.end() ? std::nullopt : std::optional(slot->place);
}

void DepthSlots::give_back_unused(std::span<const TracedMask> masks, std::size_t most) {
  std::size_t used = 0;
  std::optional<FrameId> oldest;
  for (const TracedMask& mask : masks) {
    if (used == most) break;
    if (!find(mask.frame)) continue;
    ++used;
    if (!oldest || is_newer(*oldest, mask.frame)) oldest = mask.frame;
  }
  if (used < most || !oldest) return;
  for (Slot& slot : slots_)
    if (slot.frame && is_newer(*oldest, *slot.frame)) give_back(slot);
}

void DepthSlots::forget() {
  for (Slot& slot : slots_) give_back(slot);
}

void DepthSlots::give_back(Slot& slot) {
  if (slot.frame) free_.push_back(slot.place);
  slot.frame.reset();
}

}  // namespace farshade
