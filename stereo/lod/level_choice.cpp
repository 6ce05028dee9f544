#include "stereo/lod/level_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace farshade {
namespace {

using Polygon = std::vector<glm::dvec4>;  ///< in clip space

/// The side planes of the view, as functions that are not negative inside.
constexpr int kPlanes = 4;
double inside(int plane, const glm::dvec4& p) {
  const double x = p[plane / 2];
  return plane % 2 == 0 ? p.w - x : p.w + x;
}

/// Cuts off the part of a convex polygon outside of one plane (Sutherland, Hodgman, "Reentrant polygon
/// clipping", CACM 1974).
void clip(int plane, const Polygon& polygon, Polygon& into) {
  into.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec4 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double from = inside(plane, a), to = inside(plane, b);
    if (from >= 0) into.push_back(a);
    if ((from < 0) != (to < 0)) into.push_back(glm::mix(a, b, from / (from - to)));
  }
}

/// The largest factor by which the projection stretches at the position (x, y) of the view, times w.
double stretch(const glm::dvec3& row_x, const glm::dvec3& row_y, const glm::dvec3& row_w, double x, double y,
               Extent size) {
  const glm::dvec3 a = (row_x - x * row_w) * (0.5 * size.width),
                   b = (row_y - y * row_w) * (0.5 * size.height);
  const double aa = glm::dot(a, a), bb = glm::dot(b, b), ab = glm::dot(a, b);
  return std::sqrt((aa + bb) / 2 + std::hypot((aa - bb) / 2, ab));  // the larger singular value
}

/// The least w and the range of positions on the screen, -1 to 1, of what can be seen of a box.
struct Extremes {
  double nearest = std::numeric_limits<double>::infinity();
  glm::dvec2 low{1.0}, high{-1.0};

  void add(const glm::dvec4& p) {
    nearest = std::min(nearest, p.w);
    if (!(p.w > 0)) return;
    const glm::dvec2 at = glm::clamp(glm::dvec2(p) / p.w, -1.0, 1.0);
    low = glm::min(low, at), high = glm::max(high, at);
  }
};

using Corners = std::array<glm::dvec4, 8>;

/// Whether the point where x, y and w vanish lies in the box.
bool holds_eye(const glm::dmat4& clip_from_object, const Bounds& box) {
  const glm::dmat4 rows = glm::transpose(clip_from_object);
  const glm::dmat3 linear =
      glm::transpose(glm::dmat3(glm::dvec3(rows[0]), glm::dvec3(rows[1]), glm::dvec3(rows[3])));
  if (glm::determinant(linear) == 0) return true;
  const glm::dvec3 eye = glm::inverse(linear) * -glm::dvec3(rows[0].w, rows[1].w, rows[3].w);
  return glm::all(glm::greaterThanEqual(eye, box.low)) && glm::all(glm::lessThanEqual(eye, box.high));
}

/// Of the faces of the box, clipped to the view.
Extremes clipped_extremes(const Corners& corners) {
  constexpr std::array<std::array<std::size_t, 4>, 6> kFaces{
      {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}}};
  Extremes seen;
  Polygon polygon, clipped;
  for (const std::array<std::size_t, 4>& face : kFaces) {
    polygon.clear();
    for (const std::size_t corner : face) polygon.push_back(corners[corner]);
    for (int plane = 0; plane < kPlanes; ++plane) {
      clip(plane, polygon, clipped);
      std::swap(polygon, clipped);
    }
    for (const glm::dvec4& p : polygon) seen.add(p);
  }
  return seen;
}

Extremes extremes(const glm::dmat4& clip_from_object, const Bounds& box) {
  Corners corners;
  for (int i = 0; i < 8; ++i)
    corners[static_cast<std::size_t>(i)] = clip_from_object * glm::dvec4(box.corner(i), 1.0);
  if (std::ranges::all_of(corners, [](const glm::dvec4& p) { return p.w > 0; })) {
    Extremes all;
    for (const glm::dvec4& p : corners) all.add(p);
    return all;
  }
  // Part of the box is behind the eye.
  if (holds_eye(clip_from_object, box)) return {.nearest = 0};
  return clipped_extremes(corners);
}

}  // namespace

double pixels_per_unit(const glm::dmat4& clip_from_object, const Bounds& box, Extent size) {
  const Extremes seen = extremes(clip_from_object, box);
  if (!(seen.nearest > 0)) return std::numeric_limits<double>::infinity();
  const glm::dmat4 rows = glm::transpose(clip_from_object);
  double most = 0;
  for (const double x : {seen.low.x, seen.high.x})
    for (const double y : {seen.low.y, seen.high.y})
      most =
          std::max(most, stretch(glm::dvec3(rows[0]), glm::dvec3(rows[1]), glm::dvec3(rows[3]), x, y, size));
  return most / seen.nearest;
}

std::uint32_t choose_level(std::span<const DetailLevel> levels, double px_per_unit, double most_px,
                           std::uint32_t previous) {
  std::uint32_t chosen = 0;
  for (std::uint32_t i = 0; i < levels.size(); ++i) {
    const double limit = i < previous ? most_px : most_px * kHysteresis;
    if (double{levels[i].error} * px_per_unit <= limit) chosen = i + 1;
  }
  return chosen;
}

}  // namespace farshade
