/// Packs whole answers, for tests.
#pragma once

#include "stereo/answers/frame_packer.h"

namespace farshade {

/// The messages of `frame` and `report`.
inline std::vector<std::vector<std::byte>> pack(FramePacker& packer, const ShadowFrame& frame,
                                                const FrameReport& report) {
  packer.begin();
  packer.add(frame);
  return packer.finish(report);
}

}  // namespace farshade
