/// Viewpoint: where the head stands in a scene whose file does not say so.
#pragma once

#include "stereo/scene/scene.h"

namespace farshade {

/// The scene's reference camera. Without one: at eye height in the middle of the scene if surfaces face that
/// place all around, as in a room; else in front of the scene (+z, as glTF says), a little above, with all of
/// it in view.
[[nodiscard]] Rigid<Stage, Eye> viewpoint_of(const Scene& scene);

}  // namespace farshade
