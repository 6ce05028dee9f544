/// The definition of CellFrame in double precision, written a second time: tests compare the tracer with it.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "stereo/tracer/cell_cover.h"

namespace farshade {

/// The cell and the depth of a point. In front of the single face of a directional light, points beside the
/// face count to its nearest cell.
inline CellTouch place_of(const CellFrame& frame, Point<Anchor> p) {
  const glm::dvec3 v = (p - frame.origin).v;
  const auto cell = [&](int face, double x, double y) {
    const auto at = [&](double along) { return std::clamp(static_cast<int>(along), 0, frame.side - 1); };
    return static_cast<std::uint32_t>((face * frame.side + at(y)) * frame.side + at(x));
  };
  const double half = frame.side * 0.5;
  if (!frame.cube)
    return {cell(0, glm::dot(frame.rows[0], v) + half, glm::dot(frame.rows[1], v) + half),
            static_cast<float>(glm::dot(frame.rows[2], v))};
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (std::abs(v[i]) > std::abs(v[axis])) axis = i;
  const double depth = std::abs(v[axis]);
  return {cell(2 * axis + (v[axis] < 0 ? 1 : 0), (v[axis == 0 ? 1 : 0] / depth + 1) * half,
               (v[axis == 2 ? 1 : 2] / depth + 1) * half),
          static_cast<float>(depth)};
}

}  // namespace farshade
