/// The range of a plane's words, for tests.
#pragma once

#include "stereo/frame/pixel_plane.h"

namespace farshade {

/// The largest word of `word_bytes` bytes (1 to kMaxPlaneWord_bytes).
constexpr std::uint32_t largest_word(std::uint32_t word_bytes) {
  return 0xffffffffu >> 8 * (kMaxPlaneWord_bytes - word_bytes);
}

}  // namespace farshade
