/// Closeup: float's digits go where a scene's detail is.
///
/// A tracer in float is as wrong as its largest coordinates are. One backdrop or floor of kilometres about
/// things of centimetres would cost these their shadows: the offset of a ray from a triangle follows the
/// triangle's farthest vertex (tile_stages.h). So where a scene is that lopsided, the anchor is the median of
/// its vertices instead of the middle of its box, and triangles are split until each is no longer than it is
/// far from the anchor.
#pragma once

#include <array>
#include <functional>
#include <limits>

#include "stereo/scene/scene_state.h"

namespace farshade {

struct Closeup {
  glm::dvec3 anchor{0.0};  ///< stage; what positions are relative to
  /// Edges up to this long stay whole wherever they are, metres; infinite: nothing is split.
  double near_m = std::numeric_limits<double>::infinity();
};

/// Lopsided: half of the vertices lie within 1/256 of the box's half about their median. All other scenes are
/// anchored at the middle of their box, and nothing is split.
[[nodiscard]] Closeup closeup_of(const Scene& scene, const SceneState& state);

struct Corner {
  glm::dvec3 position, normal;  ///< relative to the anchor
};

/// Calls `emit` for the parts of a triangle, in its own winding. An edge is halved while it is longer than
/// both `near_m` and its distance from the anchor: that depends on the edge alone, so that what shared an
/// edge shares its parts (longest-edge bisection, M.-C. Rivara, "Algorithms for refining triangular grids
/// suitable for adaptive and multigrid techniques", 1984).
using Emit = std::function<void(const std::array<Corner, 3>&)>;
void split_graded(const std::array<Corner, 3>& triangle, double near_m, const Emit& emit);

}  // namespace farshade
