/// PoseDelta: what moved between the view a mask was traced for and the view that is shown. Computed once, in
/// double; the shader's transform, the log's columns and the preview's numbers are all this value.
#pragma once

#include "stereo/base/clock.h"
#include "stereo/frame/view.h"

namespace farshade {

struct PoseDelta {
  Rigid<Eye, Eye> traced_from_shown;  ///< a point of the shown eye's space in the traced eye's
  double angle_rad = 0;               ///< in [0, pi]
  double distance_m = 0;              ///< between the two eyes
  Duration age{};                     ///< shown minus traced time; negative where the traced view was to come

  /// Nothing moved, to the last bit.
  [[nodiscard]] bool is_zero() const { return angle_rad == 0 && distance_m == 0; }
};

/// `shown` at `shown_at` against `traced`, traced for `traced_for`.
[[nodiscard]] PoseDelta pose_delta(const View& shown, Time shown_at, const View& traced, Time traced_for);

}  // namespace farshade
