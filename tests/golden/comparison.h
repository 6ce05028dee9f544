/// Compares a picture with its golden, with limits that allow for the rounding of other drivers.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// The difference between a picture and its golden.
struct Distance {
  double psnr_db = 0;          ///< infinite if both are equal
  double differing_share = 0;  ///< of pixels with a channel more than 2/255 away
};

/// Both pictures have one size.
[[nodiscard]] Distance distance(const Image<Rgb8>& picture, const Image<Rgb8>& golden);

/// Rounding at edges by another driver does not reach these limits; every fault tested here exceeds them.
inline constexpr double kLeastPsnr_db = 38, kMostDiffering = 0.005;

[[nodiscard]] inline bool agrees(const Distance& d) {
  return d.psnr_db >= kLeastPsnr_db && d.differing_share <= kMostDiffering;
}

}  // namespace farshade
