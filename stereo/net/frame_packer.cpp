#include "stereo/net/frame_packer.h"

#include "stereo/base/check.h"

namespace farshade {

std::span<const std::vector<std::byte>> FramePacker::pack(const ShadowFrame& frame, FrameReport report) {
  const Stopwatch packing;
  used_ = 0;
  std::size_t payload_bytes = 0;
  for (const Side side : kSides) packers_[index_of(side)].start(frame, side);
  for (bool more = true; more;) {
    more = false;
    for (SlicePacker& packer : packers_) {
      const std::optional<Slice> slice = packer.next();
      if (!slice) continue;
      std::vector<std::byte>& datagram = next_datagram();
      encode(*slice, datagram);
      payload_bytes += datagram.size();
      more = true;
    }
  }
  report.slices = narrow<std::uint32_t>(used_);
  report.payload_bytes = narrow<std::uint32_t>(payload_bytes);
  report.pack = packing.elapsed();
  encode(report, next_datagram());
  return std::span(datagrams_).first(used_);
}

std::vector<std::byte>& FramePacker::next_datagram() {
  if (used_ == datagrams_.size()) datagrams_.emplace_back();
  return datagrams_[used_++];
}

}  // namespace farshade
