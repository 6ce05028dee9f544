#include "vr_client/modes/asking.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "vr_client/ask/refresh.h"
#include "vr_client/modes/masks.h"

namespace farshade {

void Asking::skip() {
  drawn_.reset();
  messages_used_ = 0;
}

void Asking::prepare(FrameRequest& request, std::size_t slot, const RequestRecord* base,
                     const PerEye<HiddenArea>& hidden) {
  skip();
  if (!carry(request, slot, base, hidden) && !look(request, slot, hidden)) return;
  pack(request);
  if (messages_used_ == 0) return;
  request.asked = carried_.asked;
  request.answer.slices = narrow<std::uint32_t>(messages_used_);
}

/// Carries the mask of `base` over. Returns whether that leaves little enough unknown.
bool Asking::carry(const FrameRequest& request, std::size_t slot, const RequestRecord* base,
                   const PerEye<HiddenArea>& hidden) {
  if (base == nullptr) return false;
  if (to_skip_ > 0) {
    --to_skip_;
    return false;
  }
  const TracedMask mask = mask_of(*base);
  drawn_ = renderer_.carry(request, slot, &mask, carried_, &hidden);
  if (!drawn_) return false;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    add_refresh(base->request.display_time, request.display_time, carried_.asked.lights,
                carried_.covered[eye], carried_.asked.tiles[eye]);
  const bool is_little = part_of(carried_.asked) <= kMostAsked;
  last_skipped_ = is_little ? 0 : std::min(2 * last_skipped_ + 1, kMostSkipped);
  to_skip_ = last_skipped_;
  return is_little;
}

/// Finds the blocks of whole views that have a surface. Returns whether that leaves anything out: it does if
/// the lenses hide something. Otherwise the set would cost more than the sky that it leaves out.
bool Asking::look(const FrameRequest& request, std::size_t slot, const PerEye<HiddenArea>& hidden) {
  if (hidden == PerEye<HiddenArea>{}) return false;
  if (!drawn_) drawn_ = renderer_.carry(request, slot, nullptr, carried_, &hidden);
  if (!drawn_) return false;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    std::ranges::transform(carried_.covered[eye], carried_.asked.tiles[eye].begin(),
                           [&](BlockBits covered) { return all_lights_in(covered, carried_.asked.lights); });
  return true;
}

/// Writes what is asked for into messages.
void Asking::pack(const FrameRequest& request) {
  for (const Side side : kSides) {
    packer_.start(request.frame, side, request.views[index_of(side)].size, carried_.asked.lights,
                  carried_.asked.tiles[index_of(side)]);
    while (const std::optional<AskSlice> slice = packer_.next()) {
      if (messages_used_ == messages_.size()) messages_.emplace_back();
      encode(ClientMessage(*slice), messages_[messages_used_++]);
    }
  }
}

RequestParts Asking::parts() const {
  if (messages_used_ == 0) return {};
  return {.messages = std::span(messages_).first(messages_used_), .carried = &carried_.masks};
}

}  // namespace farshade
