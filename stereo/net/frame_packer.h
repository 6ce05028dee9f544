/// Frame packer: a traced frame into datagrams, in memory that is used again.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "stereo/frame/shadow_frame.h"
#include "stereo/wire/messages.h"
#include "stereo/wire/slice.h"

namespace farshade {

class FramePacker {
 public:
  explicit FramePacker(SameAllOver same = SameAllOver::OneValue)
      : packers_{SlicePacker(same), SlicePacker(same)} {}

  /// The datagrams of `frame` in the order to send them: slices of left and right in turn, so that a burst of
  /// loss falls on both, then `report`, whose `slices`, `payload_bytes` and `pack` are filled in here. Valid
  /// until the next call.
  std::span<const std::vector<std::byte>> pack(const ShadowFrame& frame, FrameReport report);

 private:
  std::vector<std::byte>& next_datagram();

  PerEye<SlicePacker> packers_;
  std::vector<std::vector<std::byte>> datagrams_;  ///< those beyond used_ keep their memory for later frames
  std::size_t used_ = 0;
};

}  // namespace farshade
