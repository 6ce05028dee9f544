/// Chosen exposure: how bright a scene is drawn whose lights have any unit.
///
/// Rays look around at the viewpoint, and once more around at what they meet. The brightness of a scene is
/// the median, over the points that any light reaches, of what a white surface would show there. If it is
/// below 1/50 or above 1.25 of white, it becomes 0.4, up to an eighth of a stop.
#pragma once

#include <string>

#include "stereo/frame/exposure.h"
#include "stereo/placement/surroundings.h"

namespace farshade {

/// For `scene`, whose surfaces are `surroundings`, seen from its viewpoint (viewpoint.h).
[[nodiscard]] Exposure chosen_exposure(const Surroundings& surroundings, const Scene& scene);

/// The same for a scene of any size; builds its Surroundings. None if there is no memory for them.
[[nodiscard]] Exposure chosen_exposure(const Scene& scene);

/// What was chosen and how to choose otherwise, as a sentence; empty if the exposure changes nothing.
[[nodiscard]] std::string in_words(const Exposure& exposure, const std::string& scene_name);

}  // namespace farshade
