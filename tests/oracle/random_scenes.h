/// Random scenes on which tracing with skipped rays, tracing without, and the oracle must agree.
#pragma once

#include <random>

#include "stereo/scene/scene.h"

namespace farshade {

/// Triangles of all sizes in and around a hall of quads, and ten lights of every kind. Three meshes move: a
/// box in the hall, a hollow lampshade around one point light, and a closed box around another.
[[nodiscard]] Scene random_soup(std::mt19937& random);

/// Boxes over a floor. Three point lights change their range and their intensity, which is 0 at time 0, and
/// three spot lights change their cone. Nothing moves.
[[nodiscard]] Scene changing_lights(std::mt19937& random);

/// Are the coarse figures of bending_figures in the scene?
enum class BendingBoxes : std::uint8_t { None, Some };

/// A hall with three lights and two deformed figures between them: a tube of `triangles` triangles whose skin
/// bends at two joints, one of which also stretches it; and three flat-shaded boxes of one rig that morph and
/// bend, one with holes, two open. The tube's first joint turns, too. One light moves, the others stand
/// still. Everything lies about `shift`.
[[nodiscard]] Scene bending_figures(std::mt19937& random, std::uint32_t triangles = 2000,
                                    const glm::dvec3& shift = glm::dvec3(0.0),
                                    BendingBoxes boxes = BendingBoxes::Some);

}  // namespace farshade
