/// Steady band: the margins of pictures that the server codes as video. A picture of another size costs a key
/// frame, and a renderer on the server. So the margins grow at once, but shrink only when nothing larger was
/// needed for two seconds, and an axis has three widths: without band, half of the largest band, all of it.
#pragma once

#include <vector>

#include "stereo/requests/guard_band.h"

namespace farshade {

class SteadyBand {
 public:
  /// The margins of the next request, for views of `size`. `needed_px`: what GuardBand asks for at present.
  /// An axis that needs no more than half of its largest growth gets that half, and the rest is divided
  /// between both of its sides in proportion to their needs. The widened views are no larger than
  /// largest_traced(size).
  Sides<std::uint32_t> margins_px(const Sides<std::uint32_t>& needed_px, Extent size);

 private:
  std::vector<Sides<std::uint32_t>> needed_px_;  ///< ring buffer
  std::size_t next_ = 0;
};

}  // namespace farshade
