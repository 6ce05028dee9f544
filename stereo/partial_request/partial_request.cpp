#include "stereo/partial_request/partial_request.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/requests/refresh.h"

namespace farshade {

void PartialRequest::skip() {
  has_begun_ = false;
  base_time_.reset();
  messages_used_ = 0;
}

void PartialRequest::begin(const FrameRequest& request, std::size_t slot, const RequestRecord* base,
                           const PerEye<HiddenArea>& hidden) {
  skip();
  // Finding what the lenses leave costs as much as reprojecting: then every request tries.
  has_lenses_ = hidden != PerEye<HiddenArea>{};
  if (has_lenses_) to_skip_ = last_skipped_ = 0;
  if (base != nullptr && to_skip_ > 0) {
    --to_skip_;
    return;
  }
  if (base != nullptr) {
    const TracedMask mask = mask_of(*base);
    has_begun_ = renderer_.reproject_to_request(request, slot, &mask, &hidden);
    if (has_begun_) base_time_ = base->request.display_time;
  }
  if (!has_begun_ && has_lenses_)
    has_begun_ = renderer_.reproject_to_request(request, slot, nullptr, &hidden);
}

void PartialRequest::complete(FrameRequest& request) {
  if (!has_begun_) return;
  renderer_.read_reprojected(reprojected_);
  if (base_time_) refresh(request);
  const bool is_much = part_of(reprojected_.requested) > kMostRequested;
  if (is_much && !has_lenses_) {
    to_skip_ = last_skipped_ = std::min(2 * last_skipped_ + 1, kMostSkipped);
    return;
  }
  last_skipped_ = 0;
  if (is_much) ask_for_surfaces();
  pack(request);
  if (messages_used_ == 0) return;
  request.requested = reprojected_.requested;
  request.answer.slices = narrow<std::uint32_t>(messages_used_);
}

/// Asks again for the tiles whose turn has come since the base.
void PartialRequest::refresh(const FrameRequest& request) {
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    add_refresh(*base_time_, request.display_time, reprojected_.requested.lights, reprojected_.covered[eye],
                reprojected_.requested.tiles[eye]);
}

/// Asks for all blocks with a surface: whole views, but for what the lenses hide.
void PartialRequest::ask_for_surfaces() {
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    std::ranges::transform(
        reprojected_.covered[eye], reprojected_.requested.tiles[eye].begin(),
        [&](BlockBits covered) { return all_lights_in(covered, reprojected_.requested.lights); });
}

/// Writes what is asked for into messages.
void PartialRequest::pack(const FrameRequest& request) {
  for (const Side side : kSides) {
    packer_.start(request.frame, side, request.views[index_of(side)].size, reprojected_.requested.lights,
                  reprojected_.requested.tiles[index_of(side)]);
    while (const std::optional<AskSlice> slice = packer_.next()) {
      if (messages_used_ == messages_.size()) messages_.emplace_back();
      encode(ClientMessage(*slice), messages_[messages_used_++]);
    }
  }
}

RequestParts PartialRequest::parts() const {
  if (messages_used_ == 0) return {};
  return {.messages = std::span(messages_).first(messages_used_), .reprojected = &reprojected_.masks};
}

}  // namespace farshade
