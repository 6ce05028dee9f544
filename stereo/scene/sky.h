/// Sky: surfaces that show what lies behind the scene, such as a sky sphere. They are seen, but cast no
/// shadow, because a light outside of them (a sun) would reach nothing.
///
/// Surfaces belong to the sky if their material is unlit, no rig deforms them, and they are closed around
/// everything else at time 0, hidden or not: the boxes of all surfaces that are lit lie in their box, and
/// from the middle of those they fill at least 45 % of all directions (a dome without a floor fills half). If
/// their fronts are seen from there, their box may be smaller by a third (the ground reaches out of a dome);
/// an unlit house is seen from outside. The sky may consist of several instances. Each fills at
/// least 4 % of the directions (the faces of a box), or all its vertices are outside of the ball around what
/// is lit and at least 0.4 times as far as the farthest vertex of the unlit (tiles, clouds, the sun's disc).
///
/// If there is no such sky, materials that emit light and whose base colour is black are taken for unlit:
/// many exporters write a sky so.
#pragma once

#include "stereo/scene/scene.h"

namespace farshade {

/// Marks the instances of the sky as casting no shadow (Instance::casts), and adds a warning that names them.
/// `scene` is complete, including its bounds.
void find_sky(Scene& scene);

/// The sky if the material were unlit; empty if there would be none of this material.
[[nodiscard]] std::vector<std::uint32_t> would_be_sky(const Scene& scene, std::uint32_t material);

/// The box around everything but the sky at time 0; Scene::bounds if there is no sky.
[[nodiscard]] Bounds bounds_without_sky(const Scene& scene);

}  // namespace farshade
