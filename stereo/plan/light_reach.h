/// Whether a light can shine into a box at all. Conservative: "no" is certain, "yes" may be wrong.
#pragma once

#include "stereo/scene/scene_state.h"

namespace farshade {

/// False only if no point of `box` (low <= high, metres, stage space) is nearer than the light's range and
/// inside its outer cone. A box that float or double cannot tell from one that the light touches counts as
/// reached.
[[nodiscard]] bool may_reach(const Light& light, const Bounds& box);

}  // namespace farshade
