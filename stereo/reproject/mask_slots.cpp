#include "stereo/reproject/mask_slots.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {

std::vector<MaskSlots::Assignment> MaskSlots::assign(std::span<const MaskVersion> masks) {
  check(masks.size() <= slots_.size(), "a frame uses at most as many masks as there are slots");
  ++calls_;
  // Mark the slots that this frame uses before any slot is evicted.
  for (const MaskVersion& mask : masks) {
    const auto slot = std::ranges::find(slots_, std::optional(mask.frame), &Slot::frame);
    if (slot != slots_.end()) slot->last_use = calls_;
  }
  std::vector<Assignment> assignments;
  for (const MaskVersion& mask : masks) {
    auto slot = std::ranges::find(slots_, std::optional(mask.frame), &Slot::frame);
    if (slot == slots_.end()) slot = std::ranges::min_element(slots_, {}, &Slot::last_use);
    const bool must_upload = slot->frame != mask.frame || slot->content != mask.content;
    *slot = {mask.frame, mask.content, calls_};
    assignments.push_back({static_cast<std::size_t>(slot - slots_.begin()), must_upload});
  }
  return assignments;
}

void MaskSlots::clear() {
  std::ranges::fill(slots_, Slot{});
}

}  // namespace farshade
