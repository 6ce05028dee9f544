/// Viewpoint: where the head stands in a scene whose file does not say so.
#pragma once

#include "stereo/scene/scene.h"

namespace farshade {

/// The scene's reference camera. Without one, rays are cast from nine places at eye height. If one of them is
/// in a room, the one with the most space around it is taken, looking to the middle. Otherwise the viewpoint
/// is in front of the scene (+z, as glTF says, unless it shows hardly anything there), a little to the right
/// and above, with all of it in view of both eyes: at least 0.25 m away, and 0.16 m from the smallest things.
/// It is level: recordings are placed upright.
///
/// A place is in a room if surfaces are seen in almost all directions, none of them nearer than 0.3 m, and if
/// it is not inside of a solid: front faces are seen, surfaces of at least three instances, or a lamp. Where
/// a lamp is seen, half the space is enough.
[[nodiscard]] Rigid<Stage, Eye> viewpoint_of(const Scene& scene);

/// The same without regard to the scene's camera.
[[nodiscard]] Rigid<Stage, Eye> chosen_viewpoint(const Scene& scene);

}  // namespace farshade
