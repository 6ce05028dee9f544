#include "vr_client/modes/masks.h"

#include <algorithm>

namespace farshade {

void MasksInHand::take(std::span<const ReceivedFrame* const> received) {
  masks_.clear();
  for (const ReceivedFrame* frame : received) {
    const FrameRequest& request = frame->request;
    masks_.push_back({request.frame, request.display_time, request.scene_time, request.views, frame->masks,
                      frame->known_tiles, std::uint64_t{frame->tiles_known[0]} << 32 | frame->tiles_known[1],
                      frame->light_set_revision});
  }
  newest_ = received.empty() ? nullptr : received.front();
}

std::vector<FrameId> MasksInHand::frames() const {
  std::vector<FrameId> frames;
  for (const TracedMask& mask : masks_)
    if (frames.size() < ShadingPass::kMaxMasks) frames.push_back(mask.frame);
  return frames;
}

/// Traced for these very pixels at this very time and with these very lights, and whole: nothing needs to be
/// carried over.
bool MasksInHand::is_exact(const TracedMask& mask, const FrameRequest& shown) const {
  const auto same = [&](std::size_t eye) {
    return shares_pixels(shown.views[eye], mask.views[eye]) &&
           is_whole(mask.known_tiles[eye], mask.masks[eye].layout());
  };
  return same(0) && same(1) && mask.light_set_revision == shown.lights.revision &&
         (same_instant(mask.scene_time, shown.scene_time) || context_.scene.animation_length_s == 0);
}

DrawnFrame MasksInHand::draw(const FrameInputs& inputs, const FrameRequest* asked, const Exchange& exchange) {
  CarryOver carry_over = inputs.steering.carry_over;
  if (!masks_.empty() && is_exact(masks_[0], inputs.shown)) carry_over.lookup = Lookup::Direct;
  DrawnFrame seen{.drawn = context_.renderer.draw({.views = inputs.shown.views,
                                                   .state = inputs.state,
                                                   .asked = asked,
                                                   .masks = masks_,
                                                   .carry_over = carry_over,
                                                   .report = inputs.steering.report})};
  // Those that it could really be drawn with: the others' depth has left the renderer's ring.
  drawn_with_.clear();
  for (const TracedMask& mask : masks_)
    if (carry_over.lookup == Lookup::Direct || context_.renderer.has_depth(mask.frame))
      drawn_with_.push_back(mask);
  seen.start_up = drawn_with_.empty();
  seen.masks = drawn_with_;
  seen.newest = newest_;
  seen.age = exchange.age(newest_, inputs);
  return seen;
}

}  // namespace farshade
