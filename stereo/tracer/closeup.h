/// Closeup: places the tracer's origin, the anchor, where most of a scene's detail is.
///
/// The errors of a tracer in float grow with the largest coordinates. One floor of kilometres among objects
/// of centimetres would remove the shadows of the small objects, since the offset of a ray from a triangle
/// follows the triangle's farthest vertex (tile_stages.h). So in such a lopsided scene the anchor is the
/// median of the vertices instead of the centre of the bounding box, and triangles are split until none is
/// longer than its distance from the anchor.
#pragma once

#include <array>
#include <functional>
#include <limits>

#include "stereo/scene/scene_state.h"
#include "stereo/tracer/anchor_space.h"

namespace farshade {

struct Closeup {
  Point<Stage> anchor;
  /// Edges up to this length are never split, metres. Infinite: nothing is split.
  double near_m = std::numeric_limits<double>::infinity();
};

/// A scene is lopsided if half of its vertices lie nearer to their median than 1/256 of half its bounding
/// box. Every other scene has its anchor at the centre of its bounding box, and nothing is split.
[[nodiscard]] Closeup closeup_of(const Scene& scene);

struct Corner {
  Point<Anchor> position;
  Vector<Anchor> normal;
};

/// Calls `emit` for the parts of a triangle, in its own winding. An edge is halved while it is longer than
/// both `near_m` and its distance from the anchor. This depends on the edge alone, so triangles that share an
/// edge split it at the same points (longest-edge bisection, M.-C. Rivara, "Algorithms for refining
/// triangular grids suitable for adaptive and multigrid techniques", 1984).
using Emit = std::function<void(const std::array<Corner, 3>&)>;
void split_graded(const std::array<Corner, 3>& triangle, double near_m, const Emit& emit);

}  // namespace farshade
