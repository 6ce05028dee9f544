/// Guard band: traced views are wider than shown ones, each side on its own, so that a head that does not go
/// where it was predicted still finds traced pixels at the border. How wide is measured, not guessed: how far
/// the border of each shown view lay outside the view predicted for it, over the last seconds, plus what the
/// head's present speed may add.
#pragma once

#include <optional>
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

/// By how many pixels the border of `shown` lies outside of `traced`'s window at its worst, for surfaces
/// kNearest_m away or further; negative where it lies inside. Pixels are those of `traced`, from its window's
/// sides.
inline constexpr double kNearest_m = 1;
[[nodiscard]] Sides<double> outside_px(const View& shown, const View& traced);

/// `view` with whole pixels added on each side: the same pixel grid, a wider window.
[[nodiscard]] View widened(const View& view, const Sides<std::uint32_t>& margins_px);

/// Views of `size` are never made larger than this.
[[nodiscard]] Extent largest_traced(Extent size);

class GuardBand {
 public:
  /// Margins are whole multiples of it: masks are traced and packed in tiles.
  static constexpr std::uint32_t kStep_px = 16;

  /// Both eyes of `predicted`, not yet widened, were what `shown` was expected to be.
  void observe(const StereoView& shown, const StereoView& predicted);

  /// For views predicted `lead` ahead and used up to `early` before and `late` after, by a head that moves as
  /// `velocity` says; `share` times as wide as was measured to be needed. largest_traced(size) holds the
  /// result.
  [[nodiscard]] Sides<std::uint32_t> margins_px(const StereoView& views, const Twist& velocity, Duration lead,
                                                Duration spread, double share = 1) const;

 private:
  std::vector<Sides<double>> seen_;  ///< a ring
  std::size_t next_ = 0;
};

}  // namespace farshade
