#include "stereo/frame/position_grid.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/check.h"

namespace farshade {

PositionGrid grid_of(Point<Stage> low, Point<Stage> high, std::uint32_t bits) {
  check(bits >= 8 && bits <= 24, "an axis of the grid has 8 to 24 bits");
  const glm::dvec3 size = high.v - low.v;
  const double longest = std::max({size.x, size.y, size.z}), side = longest > 0 ? longest : 1.0;
  const double margin = side * kGridMargin;
  return {{low.v - margin}, (side + 2 * margin) / ((1u << bits) - 2), bits};
}

void positions_of(const View& view, std::span<const float> distance_m, const PositionGrid& grid,
                  PositionPlanes& planes) {
  check_eq(distance_m.size(), view.size.pixels(), "a distance for each pixel");
  for (PixelPlane& plane : planes) {
    plane.size = view.size;
    plane.word_bytes = grid.word_bytes();
    plane.words.resize(view.size.pixels());
  }
  const FovTangents tangents = tangents_of(view.fov);
  const auto stage_ray = [&](double x, double y) {
    return view.stage_from_eye(Vector<Eye>{pixel_ray(tangents, view.size, {x, y})}).v;
  };
  const glm::dvec3 corner = stage_ray(0.5, 0.5);
  const glm::dvec3 across = stage_ray(1.5, 0.5) - corner, down = stage_ray(0.5, 1.5) - corner;
  const glm::dvec3 eye = view.stage_from_eye.translation - grid.low.v;
  const double last = (1u << grid.bits) - 2;
  for (std::uint32_t y = 0; y < view.size.height; ++y)
    for (std::uint32_t x = 0; x < view.size.width; ++x) {
      const std::size_t i = std::size_t{y} * view.size.width + x;
      const glm::dvec3 ray = corner + across * static_cast<double>(x) + down * static_cast<double>(y);
      const glm::dvec3 at = (eye + ray * double{distance_m[i]}) / grid.step_m;
      const glm::dvec3 point(std::floor(at.x + 0.5), std::floor(at.y + 0.5), std::floor(at.z + 0.5));
      const auto inside = [last](double axis) { return axis >= 0 && axis <= last; };  // false for NaN
      const bool is_inside = distance_m[i] > 0 && inside(point.x) && inside(point.y) && inside(point.z);
      for (std::size_t axis = 0; axis < 3; ++axis)
        planes[axis].words[i] = is_inside ? static_cast<std::uint32_t>(point[static_cast<int>(axis)]) + 1 : 0;
    }
}

}  // namespace farshade
