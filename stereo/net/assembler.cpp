#include "stereo/net/assembler.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

void reset(ReceivedFrame& frame, const TraceRequest& request, std::uint32_t lights, std::uint32_t revision) {
  frame.request = request;
  frame.light_set_revision = revision;
  frame.report.reset();
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const Extent size = request.views[eye].size;
    EyeMask& mask = frame.masks[eye];
    if (mask.size() == size && mask.lights() == lights) {
      std::ranges::fill(mask.bytes(), std::byte{0});
    } else {
      mask = EyeMask(size, lights);
    }
    frame.known_tiles[eye].assign(TileGrid{size}.count(), 0);
    frame.tiles_known[eye] = 0;
  }
}

}  // namespace

Assembler::Assembler(std::size_t frames) : ring_(frames) {
  check(frames > 0, "an assembler keeps a frame or more");
}

void Assembler::expect(const TraceRequest& request, std::uint32_t lights, std::uint32_t revision) {
  check(used_ == 0 || is_newer(request.frame, ring_[newest_].request.frame),
        "requests are expected in order");
  newest_ = used_ == 0 ? 0 : (newest_ + 1) % ring_.size();
  used_ = std::min(used_ + 1, ring_.size());
  reset(ring_[newest_], request, lights, revision);
}

ReceivedFrame* Assembler::slot_of(FrameId frame) {
  for (std::size_t age = 0; age < used_; ++age) {
    ReceivedFrame& slot = ring_[(newest_ + ring_.size() - age) % ring_.size()];
    if (slot.request.frame == frame) return &slot;
  }
  return nullptr;
}

const ReceivedFrame* Assembler::find(FrameId frame) const {
  return const_cast<Assembler*>(this)->slot_of(frame);
}

const ReceivedFrame* Assembler::newest_known() const {
  for (std::size_t age = 0; age < used_; ++age) {
    const ReceivedFrame& slot = ring_[(newest_ + ring_.size() - age) % ring_.size()];
    if (slot.anything_known()) return &slot;
  }
  return nullptr;
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
}

}  // namespace farshade
