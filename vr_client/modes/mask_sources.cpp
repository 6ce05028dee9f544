#include "vr_client/modes/mask_sources.h"

#include <algorithm>

namespace farshade {

TracedMask mask_of(const RequestRecord& record) {
  const FrameRequest& request = record.request;
  return {request.frame,
          request.display_time,
          request.scene_time,
          request.views,
          record.masks,
          record.known_tiles,
          std::uint64_t{record.tiles_known[0]} << 32 | record.tiles_known[1],
          record.light_set_revision};
}

void MaskSources::take(std::span<const RequestRecord* const> usable, const RequestRecord* settled) {
  records_.assign(usable.begin(), usable.end());
  std::stable_partition(records_.begin(), records_.end(),
                        [&](const RequestRecord* record) { return record == settled; });
  masks_.clear();
  for (const RequestRecord* record : records_) masks_.push_back(mask_of(*record));
}

Lookup MaskSources::lookup(const FrameRequest& shown, Lookup requested) const {
  if (masks_.empty()) return requested;
  const TracedMask& first = masks_[0];
  const auto is_same = [&](std::size_t eye) {
    return shares_pixels(shown.views[eye], first.views[eye]) &&
           is_whole(first.known_tiles[eye], first.masks[eye].layout());
  };
  const bool is_exact = is_same(0) && is_same(1) && first.light_set_revision == shown.lights.revision &&
                        (!is_animated_ || same_instant(first.scene_time, shown.scene_time));
  return is_exact ? Lookup::Direct : requested;
}

DrawnFrame MaskSources::draw(Renderer& renderer, const FrameInputs& inputs, const RequestRecord* record,
                             Exchange& exchange) {
  CarryOver carry_over = inputs.settings.carry_over;
  carry_over.lookup = lookup(inputs.shown, carry_over.lookup);
  DrawnFrame drawn{.drawn = renderer.draw({.views = inputs.shown.views,
                                           .state = inputs.state,
                                           .request = record ? &record->request : nullptr,
                                           .masks = masks_,
                                           .carry_over = carry_over,
                                           .report = inputs.settings.report,
                                           .request_slot = record ? record->slot : 0})};
  // The renderer passes over masks without depth.
  const RequestRecord* first = nullptr;
  drawn_with_.clear();
  for (std::size_t i = 0; i < masks_.size(); ++i) {
    if (carry_over.lookup != Lookup::Direct && !renderer.has_depth(masks_[i].frame)) continue;
    if (first == nullptr) first = records_[i];
    drawn_with_.push_back(masks_[i]);
  }
  if (first != nullptr) exchange.drawn_with(inputs, *first);
  drawn.start_up = drawn_with_.empty();
  drawn.masks = drawn_with_;
  if (!records_.empty()) {
    drawn.newest = records_[0];
    drawn.age = age_of(*records_[0], inputs);
  }
  return drawn;
}

}  // namespace farshade
