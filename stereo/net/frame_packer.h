/// Frame packer: a traced frame into datagrams, in memory that is used again. Both eyes are packed at the
/// same time.
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
  /// The datagrams of `frame` in the order to send them: slices of left and right in turn, so that a burst of
  /// loss falls on both, then `report`, whose `slices`, `payload_bytes` and `pack` are filled in here. Valid
  /// until the next call.
  std::span<const std::span<const std::byte>> pack(const ShadowFrame& frame, FrameReport report);

 private:
  /// One eye's datagrams; those beyond `used` keep their memory for later frames.
  struct EyeDatagrams {
    SlicePacker packer;
    std::vector<std::vector<std::byte>> bytes;
    std::size_t used = 0;
  };

  void pack_eye(const ShadowFrame& frame, Side side);

  PerEye<EyeDatagrams> eyes_;
  std::vector<std::byte> report_;
  std::vector<std::span<const std::byte>> in_order_;
};

}  // namespace farshade
