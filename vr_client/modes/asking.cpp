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
  // Finding what the lenses leave costs as much as carrying over: then every request tries.
  const bool lenses = hidden != PerEye<HiddenArea>{};
  if (lenses) to_skip_ = last_skipped_ = 0;
  if (base != nullptr && to_skip_ > 0) {
    --to_skip_;
    return;
  }
  if (base != nullptr) carry(request, slot, *base, hidden);
  if (!drawn_ && lenses) drawn_ = renderer_.carry(request, slot, nullptr, carried_, &hidden);
  if (!drawn_) return;
  const bool is_much = part_of(carried_.asked) > kMostAsked;
  if (is_much && !lenses) {
    to_skip_ = last_skipped_ = std::min(2 * last_skipped_ + 1, kMostSkipped);
    return;
  }
  last_skipped_ = 0;
  if (is_much) ask_for_surfaces();
  pack(request);
  if (messages_used_ == 0) return;
  request.asked = carried_.asked;
  request.answer.slices = narrow<std::uint32_t>(messages_used_);
}

/// Carries the mask of `base` over, and asks again for the tiles whose turn has come.
void Asking::carry(const FrameRequest& request, std::size_t slot, const RequestRecord& base,
                   const PerEye<HiddenArea>& hidden) {
  const TracedMask mask = mask_of(base);
  drawn_ = renderer_.carry(request, slot, &mask, carried_, &hidden);
  if (!drawn_) return;
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    add_refresh(base.request.display_time, request.display_time, carried_.asked.lights, carried_.covered[eye],
                carried_.asked.tiles[eye]);
}

/// Asks for all blocks with a surface: whole views, but for what the lenses hide.
void Asking::ask_for_surfaces() {
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    std::ranges::transform(carried_.covered[eye], carried_.asked.tiles[eye].begin(),
                           [&](BlockBits covered) { return all_lights_in(covered, carried_.asked.lights); });
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
