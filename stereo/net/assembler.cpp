#include "stereo/net/assembler.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

void reset(ReceivedFrame& frame, const TraceRequest& request, MaskLayout layout, std::uint32_t revision) {
  frame.request = request;
  frame.light_set_revision = revision;
  frame.report.reset();
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const Extent size = request.views[eye].size;
    EyeMask& mask = frame.masks[eye];
    if (mask.size() == size && mask.layout() == layout) {
      std::ranges::fill(mask.bytes(), std::byte{0});
    } else {
      mask = EyeMask(size, layout);
    }
    frame.known_tiles[eye].assign(TileGrid{size}.count(), 0);
    frame.tiles_known[eye] = 0;
  }
}

}  // namespace

Assembler::Assembler(std::size_t frames) : slots_(frames) {
  check(frames > kKept, "an assembler has room for more than what it keeps");
}

void Assembler::expect(const TraceRequest& request, MaskLayout layout, std::uint32_t revision) {
  check(!newest_ || is_newer(request.frame, *newest_), "requests are expected in order");
  newest_ = request.frame;
  reset(room(), request, layout, revision);
}

bool Assembler::is_kept(const ReceivedFrame& frame) const {
  if (!frame.anything_known()) return false;
  const auto newer = std::ranges::count_if(remembered(), [&](const ReceivedFrame& other) {
    return other.anything_known() && is_newer(other.request.frame, frame.request.frame);
  });
  return static_cast<std::size_t>(newer) < kKept;
}

/// A slot for one more request.
ReceivedFrame& Assembler::room() {
  if (used_ < slots_.size()) return slots_[used_++];
  ReceivedFrame* oldest = nullptr;
  for (ReceivedFrame& slot : slots_)
    if (!is_kept(slot) && (!oldest || is_newer(oldest->request.frame, slot.request.frame))) oldest = &slot;
  check(oldest != nullptr, "what is kept leaves room");
  return *oldest;
}

ReceivedFrame* Assembler::slot_of(FrameId frame) {
  for (ReceivedFrame& slot : std::span(slots_).first(used_))
    if (slot.request.frame == frame) return &slot;
  return nullptr;
}

const ReceivedFrame* Assembler::find(FrameId frame) const {
  return const_cast<Assembler*>(this)->slot_of(frame);
}

const ReceivedFrame* Assembler::newest_known() const {
  const ReceivedFrame* newest = nullptr;
  for (const ReceivedFrame& slot : remembered())
    if (slot.anything_known() && (!newest || is_newer(slot.request.frame, newest->request.frame)))
      newest = &slot;
  return newest;
}

const ReceivedFrame* Assembler::accept(const Slice& slice) {
  ReceivedFrame* const frame = slot_of(slice.frame);
  if (frame == nullptr) {
    ++counters_.unexpected;
    return nullptr;
  }
  if (slice.light_set_revision != frame->light_set_revision) {
    ++counters_.other_light_set;
    return nullptr;
  }
  const std::size_t eye = index_of(slice.eye);
  const Decoded<std::uint32_t> news = decode_slice_tiles(slice, frame->masks[eye], frame->known_tiles[eye]);
  if (!news) {
    counters_.refused.count(news.error());
    return nullptr;
  }
  ++(*news > 0 ? counters_.slices : counters_.duplicates);
  frame->tiles_known[eye] += *news;
  return *news > 0 ? frame : nullptr;
}

const ReceivedFrame* Assembler::accept(const FrameReport& report) {
  ReceivedFrame* const frame = slot_of(report.frame);
  if (frame == nullptr) {
    ++counters_.unexpected;
    return nullptr;
  }
  frame->report = report;
  return frame;
}

void Assembler::clear() {
  used_ = 0;
  newest_.reset();
}

}  // namespace farshade
