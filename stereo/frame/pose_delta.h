/// PoseDelta: the difference between the view for which a mask was traced and the shown view, in double. The
/// shaders, the logs and the preview use the same value.
#pragma once

#include "stereo/base/clock.h"
#include "stereo/frame/view.h"

namespace farshade {

struct PoseDelta {
  Rigid<Eye, Eye> traced_from_shown;  ///< maps points of the shown eye's space to the traced eye's space
  double angle_rad = 0;               ///< in [0, pi]
  double distance_m = 0;              ///< between the two eyes
  Duration age{};  ///< shown minus traced time; negative if the traced view is for a later time
};

/// Compares `shown` at time `shown_at` with `traced`, which was traced for time `traced_for`.
[[nodiscard]] PoseDelta pose_delta(const View& shown, Time shown_at, const View& traced, Time traced_for);

}  // namespace farshade
