/// The one judgement of a picture against its golden, and how far pictures of one build may stray from
/// another's.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// How far a picture is from its golden.
struct Distance {
  double psnr_db = 0;          ///< infinite if equal
  double differing_share = 0;  ///< of pixels with a channel more than 2/255 away
};

/// Both of one size.
[[nodiscard]] Distance distance(const Image<Rgb8>& picture, const Image<Rgb8>& golden);

/// Room for another driver's rounding at edges; less than any fault that tests/golden knows.
inline constexpr double kLeastPsnr_db = 38, kMostDiffering = 0.005;

[[nodiscard]] inline bool agrees(const Distance& d) {
  return d.psnr_db >= kLeastPsnr_db && d.differing_share <= kMostDiffering;
}

}  // namespace farshade
