#include "stereo/answers/assembler.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/codec/mask_block.h"
#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

void clear(EyeMask& mask, Extent size, MaskLayout layout) {
  if (mask.size() == size && mask.layout() == layout)
    std::ranges::fill(mask.bytes(), std::byte{0});
  else
    mask = EyeMask(size, layout);
}

/// The first slice allocates the words.
void clear(ReceivedGBuffer& gbuffer) {
  for (const PlaneKind kind : kGBufferKinds)
    for (PixelPlane& plane : planes_of(gbuffer.planes, kind)) plane.size = {};
  gbuffer.tiles_known = gbuffer.tiles = 0;
}

/// 3 bytes for base colour, 4 for the others.
std::uint32_t word_bytes_of(PlaneKind kind) {
  return kind == PlaneKind::BaseColor ? 3 : 4;
}

void begin(ReceivedGBuffer& gbuffer, const StereoView& views) {
  for (std::size_t kind = 0; kind < kGBufferKinds.size(); ++kind)
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      PixelPlane& plane = planes_of(gbuffer.planes, kGBufferKinds[kind])[eye];
      plane.size = views[eye].size;
      plane.word_bytes = word_bytes_of(kGBufferKinds[kind]);
      plane.words.assign(plane.size.pixels(), 0);
      gbuffer.received_tiles[kind][eye].assign(TileGrid{plane.size}.count(), 0);
      gbuffer.tiles += TileGrid{plane.size}.count();
    }
}

/// What a request asks for of an eye's masks; empty: all.
std::span<const RequestedTile> requested_of(const FrameRequest& request, std::size_t eye) {
  if (request.answer.kind != Answer::Masks) return {};
  return request.requested.tiles[eye];
}

void reset(RequestRecord& frame, const FrameRequest& request, MaskLayout layout, LightSetRevision revision) {
  frame.request = request;
  frame.light_set_revision = revision;
  frame.report.reset();
  frame.first_piece.reset();
  frame.report_arrived.reset();
  clear(frame.gbuffer);
  frame.video.known.clear();
  frame.video.parts_known = 0;
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    const Extent size = has_masks(request.answer.kind) ? request.views[eye].size : Extent{};
    clear(frame.masks[eye], size, layout);
    frame.received_tiles[eye].assign(TileGrid{size}.count(), 0);
    frame.tiles_known[eye] = 0;
    frame.tiles_requested[eye] =
        RequestedTiles(size, layout.lights, requested_of(frame.request, eye)).count();
  }
}

/// The most parts of a block of masks.
std::size_t most_parts(const PerEye<EyeMask>& masks) {
  return (most_mask_block_bytes(masks) + kVideoPart_bytes - 1) / kVideoPart_bytes;
}

/// Of a block of masks all parts have come: all tiles are known.
Decoded<void> open_masks(RequestRecord& frame) {
  const Decoded<void> opened = decode_mask_block(frame.video.unit, frame.light_set_revision, frame.masks);
  if (!opened) return opened;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const MaskLayout layout = frame.masks[eye].layout();
    std::ranges::fill(frame.received_tiles[eye], all_planes_received(layout));
    frame.tiles_known[eye] = frame.tiles_requested[eye] * layout.planes();
  }
  return {};
}

}  // namespace

AssemblerCounters& AssemblerCounters::operator+=(const AssemblerCounters& other) {
  slices += other.slices;
  duplicates += other.duplicates;
  unexpected += other.unexpected;
  other_light_set += other.other_light_set;
  for (std::size_t i = 0; i < refused.of.size(); ++i) refused.of[i] += other.refused.of[i];
  return *this;
}

bool RequestRecord::complete() const {
  const Answer answer = request.answer.kind;
  if (is_video(answer)) return video.complete();
  const bool has_planes =
      answer != Answer::GBuffer || (gbuffer.tiles > 0 && gbuffer.tiles_known == gbuffer.tiles);
  return has_planes && complete(Side::Left) && complete(Side::Right);
}

TracedMask mask_of(const RequestRecord& record) {
  const FrameRequest& request = record.request;
  return {request.frame,
          request.display_time,
          request.scene_time,
          request.views,
          record.masks,
          record.received_tiles,
          std::uint64_t{record.tiles_known[0]} << 32 | record.tiles_known[1],
          record.light_set_revision,
          &request.requested,
          record.origin.requested_at};
}

Assembler::Assembler(std::size_t frames) : slots_(frames) {
  for (std::size_t slot = 0; slot < frames; ++slot) slots_[slot].slot = slot;
  check(frames > kKept, "an assembler has room for more than what it keeps");
}

void Assembler::expect(const FrameRequest& request, MaskLayout layout, LightSetRevision revision,
                       const RequestOrigin& origin, const PerEye<EyeMask>* reprojected) {
  check(!newest_ || is_newer(request.frame, *newest_), "requests are expected in order");
  newest_ = request.frame;
  RequestRecord& record = slots_[next_slot()];
  used_ = std::max(used_, record.slot + 1);
  reset(record, request, layout, revision);
  if (reprojected != nullptr) {
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const EyeMask& bits = (*reprojected)[eye];
      check(bits.size() == request.views[eye].size && bits.layout() == layout,
            "reprojected masks fit their request");
      std::ranges::copy(bits.bytes(), record.masks[eye].bytes().begin());
    }
  }
  record.origin = origin;
}

bool Assembler::is_kept(const RequestRecord& frame) const {
  if (!frame.anything_known()) return false;
  const auto newer = std::ranges::count_if(records(), [&](const RequestRecord& other) {
    return other.anything_known() && is_newer(other.request.frame, frame.request.frame);
  });
  return static_cast<std::size_t>(newer) < kKept;
}

std::size_t Assembler::next_slot() const {
  if (used_ < slots_.size()) return used_;
  const RequestRecord* oldest = nullptr;
  for (const RequestRecord& record : slots_)
    if (!is_kept(record) && (!oldest || is_newer(oldest->request.frame, record.request.frame)))
      oldest = &record;
  check(oldest != nullptr, "the eviction rule leaves a slot");
  return oldest->slot;
}

RequestRecord* Assembler::slot_of(FrameId frame) {
  for (RequestRecord& slot : std::span(slots_).first(used_))
    if (slot.request.frame == frame) return &slot;
  return nullptr;
}

const RequestRecord* Assembler::find(FrameId frame) const {
  return const_cast<Assembler*>(this)->slot_of(frame);
}

const RequestRecord* Assembler::newest_known() const {
  const RequestRecord* newest = nullptr;
  for (const RequestRecord& slot : records())
    if (slot.anything_known() && (!newest || is_newer(slot.request.frame, newest->request.frame)))
      newest = &slot;
  return newest;
}

/// The record of a request that is still remembered.
RequestRecord* Assembler::find_or_count(FrameId frame) {
  RequestRecord* const found = slot_of(frame);
  if (found == nullptr) ++counters_.unexpected;
  return found;
}

const RequestRecord* Assembler::count(RequestRecord& record, const Decoded<std::uint32_t>& news,
                                      std::uint32_t& known, Time arrived) {
  if (!news) {
    counters_.refused.count(news.error());
    return nullptr;
  }
  ++(*news > 0 ? counters_.slices : counters_.duplicates);
  known += *news;
  if (*news > 0 && !record.first_piece) record.first_piece = arrived;
  return *news > 0 ? &record : nullptr;
}

const RequestRecord* Assembler::accept(const Slice& slice, Time arrived) {
  RequestRecord* const frame = find_or_count(slice.frame);
  if (frame == nullptr) return nullptr;
  if (slice.light_set_revision != frame->light_set_revision) {
    ++counters_.other_light_set;
    return nullptr;
  }
  const std::size_t eye = index_of(slice.eye);
  if (frame->request.answer.coding == Coding::Lz4)
    return count(*frame, refuse(WireRefusal::AnswerSpec), frame->tiles_known[eye], arrived);
  const std::span<const RequestedTile> requested = requested_of(frame->request, eye);
  return count(*frame, decode_slice_tiles(slice, requested, frame->masks[eye], frame->received_tiles[eye]),
               frame->tiles_known[eye], arrived);
}

const RequestRecord* Assembler::accept(const PlaneSlice& slice, Time arrived) {
  RequestRecord* const frame = find_or_count(slice.frame);
  if (frame == nullptr) return nullptr;
  ReceivedGBuffer& gbuffer = frame->gbuffer;
  if (frame->request.answer.kind != Answer::GBuffer || slice.kind > PlaneKind::Depth)
    return count(*frame, refuse(WireRefusal::AnswerSpec), gbuffer.tiles_known, arrived);
  if (gbuffer.tiles == 0) begin(gbuffer, frame->request.views);
  const std::size_t eye = index_of(slice.eye), kind = static_cast<std::size_t>(slice.kind);
  return count(*frame,
               decode_plane_tiles(slice, planes_of(gbuffer.planes, slice.kind)[eye],
                                  gbuffer.received_tiles[kind][eye]),
               gbuffer.tiles_known, arrived);
}

const RequestRecord* Assembler::accept(const VideoPart& part, Time arrived) {
  RequestRecord* const frame = find_or_count(part.frame);
  if (frame == nullptr) return nullptr;
  ReceivedVideo& video = frame->video;
  const auto take = [&]() -> Decoded<std::uint32_t> {
    const bool of_masks = frame->request.answer.coding == Coding::Lz4;
    if (!of_masks && !is_video(frame->request.answer.kind)) return refuse(WireRefusal::AnswerSpec);
    if (of_masks && (part.after != part.frame || part.parts > most_parts(frame->masks)))
      return refuse(WireRefusal::Part);
    if (video.known.empty()) {
      video.after = part.after;
      video.known.assign(part.parts, false);
      video.unit.assign(part.parts * kVideoPart_bytes, std::byte{0});
    }
    if (video.known.size() != part.parts || video.after != part.after) return refuse(WireRefusal::Part);
    if (video.known[part.part]) return 0u;
    video.known[part.part] = true;
    const std::size_t at = part.part * kVideoPart_bytes;
    std::ranges::copy(part.bytes, video.unit.begin() + static_cast<std::ptrdiff_t>(at));
    if (part.part + 1 == part.parts) video.unit.resize(at + part.bytes.size());
    if (of_masks && video.parts_known + 1 == part.parts)
      if (const Decoded<void> opened = open_masks(*frame); !opened) return refuse(opened.error());
    return 1u;
  };
  return count(*frame, take(), video.parts_known, arrived);
}

const RequestRecord* Assembler::accept(const FrameReport& report, Time arrived) {
  RequestRecord* const frame = find_or_count(report.frame);
  if (frame == nullptr) return nullptr;
  frame->report = report;
  frame->report_arrived = arrived;
  return frame;
}

}  // namespace farshade
