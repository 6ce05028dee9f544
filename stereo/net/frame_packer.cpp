#include "stereo/net/frame_packer.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {

void FramePacker::pack_eye(const ShadowFrame& frame, Side side) {
  EyeDatagrams& eye = eyes_[index_of(side)];
  eye.used = 0;
  eye.packer.start(frame, side);
  while (const std::optional<Slice> slice = eye.packer.next()) {
    if (eye.used == eye.bytes.size()) eye.bytes.emplace_back();
    encode(*slice, eye.bytes[eye.used++]);
  }
}

std::span<const std::span<const std::byte>> FramePacker::pack(const ShadowFrame& frame, FrameReport report) {
  const Stopwatch packing;
  tbb::parallel_for(std::size_t{0}, kEyes, [&](std::size_t eye) { pack_eye(frame, kSides[eye]); });

  in_order_.clear();
  std::size_t payload_bytes = 0;
  for (std::size_t i = 0; i < std::max(eyes_[0].used, eyes_[1].used); ++i) {
    for (const EyeDatagrams& eye : eyes_) {
      if (i >= eye.used) continue;
      in_order_.emplace_back(eye.bytes[i]);
      payload_bytes += eye.bytes[i].size();
    }
  }
  report.slices = narrow<std::uint32_t>(in_order_.size());
  report.payload_bytes = narrow<std::uint32_t>(payload_bytes);
  report.pack = packing.elapsed();
  encode(report, report_);
  in_order_.emplace_back(report_);
  return in_order_;
}

}  // namespace farshade
