/// Guard band: each side of a traced view is widened on its own, so that masks still cover the border of the
/// shown view when the head moves otherwise than predicted, or when the masks come later than expected. The
/// width is measured: the distance by which shown views lay outside the views that their masks were traced
/// for, over the last two seconds, plus a term for the head's present speed.
#pragma once

#include <vector>

#include "stereo/base/clock.h"
#include "stereo/frame/view.h"
#include "stereo/math/twist.h"

namespace farshade {

/// One number for each side of a view.
template <class T>
struct Sides {
  T left{}, right{}, up{}, down{};
  friend bool operator==(const Sides&, const Sides&) = default;
};

/// The largest distance by which the border of `shown` lies outside each side of `traced`, for surfaces at
/// kNearest_m or further away. In pixels of `traced`; negative where the border lies inside.
inline constexpr double kNearest_m = 1;
[[nodiscard]] Sides<double> outside_px(const View& shown, const View& traced);

/// `view` with whole pixels added on each side. The pixel grid stays the same.
[[nodiscard]] View widened(const View& view, const Sides<std::uint32_t>& margins_px);

/// The largest size that a guard band gives to valid views of `size`.
[[nodiscard]] Extent largest_traced(Extent size);

/// The part of the needed margins with which both views stay valid and have at most `most_pixels` pixels
/// each. Each step of GuardBand::kStep_px goes to the side that misses most, as long as it fits.
[[nodiscard]] Sides<std::uint32_t> reduced_to_fit(const StereoView& views,
                                                  const Sides<std::uint32_t>& needed_px,
                                                  std::uint64_t most_pixels);

class GuardBand {
 public:
  /// Margins are multiples of this step, because masks are traced and packed in tiles.
  static constexpr std::uint32_t kStep_px = 16;

  /// A frame with the views `shown` was drawn with masks of `traced`. Both have the same window and size:
  /// `traced` without its guard band.
  void observe(const StereoView& shown, const StereoView& traced);

  /// The margins for views that are predicted `lead` ahead, and whose masks are used from `spread` before to
  /// `spread` after that time, while the head moves with `velocity`. `share` scales the margins before they
  /// are rounded. The widened views are no larger than largest_traced(size).
  [[nodiscard]] Sides<std::uint32_t> margins_px(const StereoView& views, const Twist& velocity, Duration lead,
                                                Duration spread, double share = 1) const;

 private:
  std::vector<Sides<double>> observed_px_;  ///< ring buffer
  std::size_t next_ = 0;
};

}  // namespace farshade
