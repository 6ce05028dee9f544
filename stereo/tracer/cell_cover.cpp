#include "stereo/tracer/cell_cover.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace farshade {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Relative margin of depths, which are later compared in float. It may be 0 while CellFrame::rounding is at
/// least 4 u M.
constexpr double kDepthShare = 1e-5;

/// A corner in front of a face, homogeneous: x and y are in cells times w. `near` grows towards the light and
/// is linear in x / w and y / w: it is 1 / depth on a cube, and -depth otherwise.
struct FaceCorner {
  double x, y, w, near;
};

/// The corners of a clipped triangle: three, and at most one more for each side of the face.
struct Polygon {
  std::array<FaceCorner, 7> corner;
  std::size_t count = 0;

  void add(const FaceCorner& c) { corner[count++] = c; }
  [[nodiscard]] const FaceCorner& after(std::size_t i) const { return corner[i + 1 == count ? 0 : i + 1]; }
};

/// CellFrame::rounding in units of cells times w.
double rounding_of(const CellFrame& frame) {
  return frame.rounding * (frame.cube ? frame.side * 0.5 : glm::length(frame.rows[0]));
}

FaceCorner corner_of(const CellFrame& frame, int face, const glm::dvec3& v) {
  const double half = frame.side * 0.5;
  if (!frame.cube)
    return {glm::dot(frame.rows[0], v) + half, glm::dot(frame.rows[1], v) + half, 1,
            -glm::dot(frame.rows[2], v)};
  const int axis = face / 2;
  const double w = face % 2 == 0 ? v[axis] : -v[axis];
  return {(v[axis == 0 ? 1 : 0] + w) * half, (v[axis == 2 ? 1 : 2] + w) * half, w, 0};
}

/// Signed distance of a corner from one of the four sides of the face, positive inside, in cells times w.
double inside_by(const CellFrame& frame, double rounding, const FaceCorner& c, int which) {
  const double along = which < 2 ? c.x : c.y;
  return (which % 2 == 0 ? along : frame.side * c.w - along) + CellFrame::kMargin * c.w + rounding;
}

FaceCorner between(const FaceCorner& a, const FaceCorner& b, double t) {
  return {a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.w + (b.w - a.w) * t,
          a.near + (b.near - a.near) * t};
}

/// Clips to the face. Empty if the triangle is beside the face.
Polygon clipped(const CellFrame& frame, double rounding, Polygon polygon) {
  for (int which = 0; which < 4 && polygon.count > 0; ++which) {
    std::array<double, 7> inside;
    double least = kInfinity;
    for (std::size_t i = 0; i < polygon.count; ++i) {
      inside[i] = inside_by(frame, rounding, polygon.corner[i], which);
      least = std::min(least, inside[i]);
    }
    if (least >= 0) continue;
    Polygon kept;
    for (std::size_t i = 0; i < polygon.count; ++i) {
      const double from_a = inside[i], from_b = inside[i + 1 == polygon.count ? 0 : i + 1];
      if (from_a >= 0) kept.add(polygon.corner[i]);
      if ((from_a >= 0) != (from_b >= 0))
        kept.add(between(polygon.corner[i], polygon.after(i), from_a / (from_a - from_b)));
    }
    polygon = kept;
  }
  return polygon;
}

/// The part of a polygon between two borders of rows: its columns from low to high, and its nearest point.
struct RowExtent {
  double low = kInfinity, high = -kInfinity, near = -kInfinity;

  void add(const FaceCorner& c) {
    low = std::min(low, c.x), high = std::max(high, c.x);
    near = std::max(near, c.near);
  }
};

RowExtent extent_within(const Polygon& polygon, double top, double bottom) {
  RowExtent extent;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const FaceCorner &a = polygon.corner[i], &b = polygon.after(i);
    if (a.y >= top && a.y <= bottom) extent.add(a);
    for (const double border : {top, bottom})
      if ((a.y < border) != (b.y < border)) extent.add(between(a, b, (border - a.y) / (b.y - a.y)));
  }
  return extent;
}

int cell_at(double along, int side) {
  return static_cast<int>(std::clamp(std::floor(along), 0.0, side - 1.0));
}

void cover_face(const CellFrame& frame, std::uint32_t first_cell, Polygon polygon, double rounding,
                std::vector<CellTouch>& touched) {
  double least_w = kInfinity, top = kInfinity, bottom = -kInfinity;
  for (std::size_t i = 0; i < polygon.count; ++i) least_w = std::min(least_w, polygon.corner[i].w);
  const auto side = static_cast<std::uint32_t>(frame.side);
  // It touches the light: it may block any direction. A larger factor is safe, but proves less.
  if (frame.cube && least_w <= 4 * frame.rounding) {
    for (std::uint32_t i = 0; i < side * side; ++i) touched.push_back({first_cell + i, 0.0f});
    return;
  }
  for (std::size_t i = 0; i < polygon.count; ++i) {
    FaceCorner& c = polygon.corner[i];
    if (frame.cube) c = {c.x / c.w, c.y / c.w, 1, 1 / c.w};
    top = std::min(top, c.y), bottom = std::max(bottom, c.y);
  }
  const double margin = CellFrame::kMargin + rounding / least_w;
  const int last = cell_at(bottom + margin, frame.side);
  for (int row = cell_at(top - margin, frame.side); row <= last; ++row) {
    const RowExtent extent = extent_within(polygon, row - margin, row + 1 + margin);
    if (extent.low > extent.high) continue;
    const double depth = (frame.cube ? (1 - kDepthShare) / extent.near : -extent.near) - frame.rounding;
    const int right = cell_at(extent.high + margin, frame.side);
    for (int column = cell_at(extent.low - margin, frame.side); column <= right; ++column)
      touched.push_back(
          {first_cell + static_cast<std::uint32_t>(row) * side + static_cast<std::uint32_t>(column),
           static_cast<float>(depth)});
  }
}

/// A fast path of `cover` for a triangle within one row or column of one face of a cube, as most triangles of
/// a detailed scene are. `v` is relative to the light. Returns false, without effect, for any other triangle.
bool cover_small(const CellFrame& frame, const std::array<glm::dvec3, 3>& v, double rounding,
                 std::vector<CellTouch>& touched) {
  const glm::dvec3 middle = v[0] + v[1] + v[2], size = glm::abs(middle);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const int face = 2 * axis + (middle[axis] < 0 ? 1 : 0);
  double least = kInfinity, left = kInfinity, right = -kInfinity, top = kInfinity, bottom = -kInfinity;
  for (const glm::dvec3& corner : v) {
    const FaceCorner c = corner_of(frame, face, corner);
    if (c.w <= 4 * frame.rounding) return false;
    least = std::min(least, c.w);
    left = std::min(left, c.x / c.w), right = std::max(right, c.x / c.w);
    top = std::min(top, c.y / c.w), bottom = std::max(bottom, c.y / c.w);
  }
  const double margin = CellFrame::kMargin + rounding / least;
  left = std::floor(left - margin), right = std::floor(right + margin);
  top = std::floor(top - margin), bottom = std::floor(bottom + margin);
  if (left < 0 || top < 0 || right >= frame.side || bottom >= frame.side) return false;
  if (left != right && top != bottom) return false;
  const double depth = least * (1 - kDepthShare) - frame.rounding;
  for (int row = static_cast<int>(top); row <= static_cast<int>(bottom); ++row)
    for (int column = static_cast<int>(left); column <= static_cast<int>(right); ++column)
      touched.push_back({static_cast<std::uint32_t>((face * frame.side + row) * frame.side + column),
                         static_cast<float>(depth)});
  return true;
}

}  // namespace

void cover(const CellFrame& frame, const std::array<Point<Anchor>, 3>& triangle,
           std::vector<CellTouch>& touched) {
  const double rounding = rounding_of(frame);
  const std::array<glm::dvec3, 3> v{(triangle[0] - frame.origin).v, (triangle[1] - frame.origin).v,
                                    (triangle[2] - frame.origin).v};
  if (frame.cube && cover_small(frame, v, rounding, touched)) return;
  for (int face = 0; face < frame.faces(); ++face) {
    const int axis = face / 2;
    const double sign = face % 2 == 0 ? 1 : -1;
    if (frame.cube && std::max({v[0][axis] * sign, v[1][axis] * sign, v[2][axis] * sign}) < -rounding)
      continue;
    Polygon polygon;
    for (const glm::dvec3& p : v) polygon.add(corner_of(frame, face, p));
    polygon = clipped(frame, rounding, polygon);
    if (polygon.count > 0)
      cover_face(frame, static_cast<std::uint32_t>(face * frame.side * frame.side), polygon, rounding,
                 touched);
  }
}

}  // namespace farshade
