/// Whether a light can shine into a box at all: conservative, so that "no" is certain and "yes" may be wrong.
#pragma once

#include "stereo/scene/scene_state.h"

namespace farshade {

/// False only if no point of `box` (low <= high, metres, stage space) is nearer than the light's range and
/// inside of its outer cone. Boxes and lights that float or double cannot tell from touching count as
/// reached.
[[nodiscard]] bool may_reach(const Light& light, const Bounds& box);

}  // namespace farshade
