/// Random scenes on which tracing with proofs, tracing without them, and the oracle must agree.
#pragma once

#include <random>

#include "stereo/scene/scene.h"

namespace farshade {

/// Triangles of all sizes in and around a hall of quads, and ten lights of every kind. Three meshes move: a
/// box in the hall, a hollow lampshade around one point light, and a closed box around another.
[[nodiscard]] Scene random_soup(std::mt19937& random);

}  // namespace farshade
