#include "vr_client/modes/masks.h"

#include <algorithm>

namespace farshade {

void MasksInHand::take(std::span<const ReceivedFrame* const> received) {
  masks_.clear();
  for (const ReceivedFrame* frame : received) {
    const TraceRequest& request = frame->request;
    masks_.push_back({request.frame, request.display_time, request.scene_time, request.views, frame->masks,
                      frame->known_tiles, std::uint64_t{frame->tiles_known[0]} << 32 | frame->tiles_known[1],
                      frame->light_set_revision});
  }
  newest_ = received.empty() ? nullptr : received.front();
}

std::vector<FrameId> MasksInHand::frames() const {
  std::vector<FrameId> frames;
  for (const MaskInHand& mask : masks_)
    if (frames.size() < ShadingPass::kMaxMasks) frames.push_back(mask.frame);
  return frames;
}

/// Traced for these very pixels at this very time and with these very lights, and whole: nothing needs to be
/// carried over.
bool MasksInHand::is_exact(const MaskInHand& mask, const TraceRequest& shown) const {
  const auto same = [&](std::size_t eye) {
    return shares_pixels(shown.views[eye], mask.views[eye]) &&
           is_whole(mask.known_tiles[eye], mask.masks[eye].layout());
  };
  return same(0) && same(1) && mask.light_set_revision == shown.lights.revision &&
         (same_instant(mask.scene_time, shown.scene_time) || session_.scene.animation_length_s == 0);
}

Seen MasksInHand::draw(const Moment& moment, const TraceRequest* asked, const Exchange& exchange) {
  CarryOver carry_over = moment.steering.carry_over;
  if (!masks_.empty() && is_exact(masks_[0], moment.shown)) carry_over.lookup = Lookup::Direct;
  Seen seen{.drawn = session_.renderer.draw({.views = moment.shown.views,
                                             .state = moment.state,
                                             .asked = asked,
                                             .masks = masks_,
                                             .carry_over = carry_over,
                                             .report = moment.steering.report})};
  // Those that it could really be drawn with: the others' depth has left the renderer's ring.
  drawn_with_.clear();
  for (const MaskInHand& mask : masks_)
    if (carry_over.lookup == Lookup::Direct || session_.renderer.has_depth(mask.frame))
      drawn_with_.push_back(mask);
  seen.start_up = drawn_with_.empty();
  seen.masks = drawn_with_;
  seen.newest = newest_;
  seen.age = exchange.age(newest_, moment);
  return seen;
}

}  // namespace farshade
