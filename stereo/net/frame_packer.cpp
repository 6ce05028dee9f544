#include "stereo/net/frame_packer.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {

void FramePacker::begin() {
  used_ = payload_bytes_ = 0;
  packing_ = {};
}

void FramePacker::add(const ServerMessage& message) {
  std::vector<std::byte>& datagram = next_datagram();
  encode(message, datagram);
  payload_bytes_ += datagram.size();
}

void FramePacker::add(const ShadowFrame& frame, const PerEye<std::span<const std::uint8_t>>& sent) {
  const Stopwatch packing;
  for (const Side side : kSides) packers_[index_of(side)].start(frame, side, sent[index_of(side)]);
  for (bool more = true; more;) {
    more = false;
    for (SlicePacker& packer : packers_)
      if (const std::optional<Slice> slice = packer.next()) {
        add(ServerMessage(*slice));
        more = true;
      }
  }
  packing_ += packing.elapsed();
}

void FramePacker::add(FrameId frame, const GBufferPlanes& gbuffer) {
  const Stopwatch packing;
  for (const PlaneKind kind : kGBufferKinds)
    for (const Side side : kSides) {
      plane_packer_.start(frame, side, kind, planes_of(gbuffer, kind)[index_of(side)]);
      while (const std::optional<PlaneSlice> slice = plane_packer_.next()) add(ServerMessage(*slice));
    }
  packing_ += packing.elapsed();
}

void FramePacker::add(FrameId frame, FrameId after, std::span<const std::byte> video_unit) {
  const Stopwatch packing;
  const auto parts = narrow<std::uint32_t>((video_unit.size() + kVideoPart_bytes - 1) / kVideoPart_bytes);
  check(parts >= 1 && parts <= kMostVideoParts, "a coded picture has so many parts");
  for (std::uint32_t part = 0; part < parts; ++part) {
    const std::size_t at = part * kVideoPart_bytes;
    const std::size_t bytes = std::min(kVideoPart_bytes, video_unit.size() - at);
    add(ServerMessage(VideoPart{.frame = frame,
                                .after = after,
                                .part = part,
                                .parts = parts,
                                .bytes = video_unit.subspan(at, bytes)}));
  }
  packing_ += packing.elapsed();
}

std::span<const std::vector<std::byte>> FramePacker::finish(FrameReport report) {
  report.slices = narrow<std::uint32_t>(used_);
  report.payload_bytes = narrow<std::uint32_t>(payload_bytes_);
  report.pack += packing_;
  encode(report, next_datagram());
  return std::span(datagrams_).first(used_);
}

std::vector<std::byte>& FramePacker::next_datagram() {
  if (used_ == datagrams_.size()) datagrams_.emplace_back();
  return datagrams_[used_++];
}

}  // namespace farshade
