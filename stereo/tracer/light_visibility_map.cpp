#include "stereo/tracer/light_visibility_map.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "stereo/tracer/ray_packet.h"

namespace farshade {
namespace {

constexpr double kUlp = 1.0 / (1 << 24);  // u in tile_stages.h
/// Rays and triangles are displaced by at most this many u M: rounding moves them by 24 u M together.
constexpr double kRounding = 32;
/// A light is on one side of a plane for all of its rays only if it is this far from the plane (in u M;
/// directional lights: if its direction makes an angle of at least this sine with the plane).
constexpr double kLeastHeight = 64, kLeastSlope = 1e-4;
/// Instead of a plane's number: not yet looked up, or the light is on neither side of it.
constexpr std::uint32_t kUnasked = ~0u, kEdgeOn = ~0u - 1;

using Corners = std::array<Point<Anchor>, 3>;

Corners corners_of(const SurfaceModel& model, std::uint32_t triangle) {
  const glm::uvec3& t = model.triangles()[triangle];
  const auto p = model.positions();
  return {Point<Anchor>{glm::dvec3(p[t.x])}, {glm::dvec3(p[t.y])}, {glm::dvec3(p[t.z])}};
}

/// Two unit vectors perpendicular to the unit vector `w` and to each other.
std::array<glm::dvec3, 2> across(const glm::dvec3& w) {
  const glm::dvec3 other = std::abs(w.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(other, w));
  return {u, glm::cross(w, u)};
}

/// One face perpendicular to `along`, as wide as all fixed patches that cast.
void fit_across(const SurfaceModel& model, const glm::dvec3& along, CellFrame& frame) {
  const auto [u, v] = across(along);
  glm::dvec3 low(1e300), high(-1e300);
  for (const Patch& patch : model.patches().first(model.fixed_count()))
    for (std::uint32_t i = 0; patch.casts && i < patch.triangle_count; ++i)
      for (const Point<Anchor>& p : corners_of(model, patch.first_triangle + i)) {
        const glm::dvec3 q(glm::dot(u, p.v), glm::dot(v, p.v), glm::dot(along, p.v));
        low = glm::min(low, q), high = glm::max(high, q);
      }
  if (low.x > high.x) low = high = glm::dvec3(0.0);
  const glm::dvec3 middle = (low + high) * 0.5;
  frame.origin = {u * middle.x + v * middle.y + along * middle.z};
  const double extent = std::max({high.x - low.x, high.y - low.y, frame.rounding * 1e3, 1e-30});
  const double cells_a_metre = frame.side / (extent * 1.001);
  frame.rows = {u * cells_a_metre, v * cells_a_metre, along};
}

CellFrame frame_for(const ShadowLight& light, double reach, const SurfaceModel& model) {
  CellFrame frame;
  frame.side = LightVisibilityMap::kSide;
  frame.rounding = kRounding * kUlp * (reach + light.reach);
  frame.cube = light.kind != LightKind::Directional;
  if (frame.cube)
    frame.origin = {glm::dvec3(light.position.v)};
  else
    fit_across(model, glm::normalize(glm::dvec3(light.direction.v)), frame);
  return frame;
}

/// 1 = the light is certainly on the side to which the normal points, -1 = certainly on the other, 0 =
/// uncertain.
int side_of(const FacetPlane& plane, const ShadowLight& light, double reach) {
  const glm::dvec3 normal(plane.normal);
  if (light.kind == LightKind::Directional) {
    const double slope = -glm::dot(normal, glm::dvec3(light.direction.v));
    return slope > kLeastSlope ? 1 : slope < -kLeastSlope ? -1 : 0;
  }
  const double along = glm::dot(normal, glm::dvec3(light.position.v));
  const double least = kLeastHeight * kUlp * (reach + light.reach);
  return along > plane.high + least ? 1 : along < plane.low - least ? -1 : 0;
}

/// Enters a plane by its least depth. A cell keeps its nearest planes; the others count to its rest.
void enter(LightVisibilityMap::Cell& cell, std::uint32_t plane, float depth) {
  std::size_t last = 0;
  for (std::size_t i = 0; i < LightVisibilityMap::kPlanes; ++i) {
    if (cell.from[i] < kFar && cell.plane[i] == plane) {
      cell.from[i] = std::min(cell.from[i], depth);
      return;
    }
    if (cell.from[i] > cell.from[last]) last = i;
  }
  if (depth < cell.from[last]) {
    std::swap(cell.plane[last], plane);
    std::swap(cell.from[last], depth);
  }
  cell.rest = std::min(cell.rest, depth);
}

/// The twelve triangles of a box's surface.
constexpr std::array<std::array<std::size_t, 3>, 12> kBoxTriangles{{{0, 1, 3},
                                                                    {0, 3, 2},
                                                                    {4, 6, 7},
                                                                    {4, 7, 5},
                                                                    {0, 4, 5},
                                                                    {0, 5, 1},
                                                                    {2, 3, 7},
                                                                    {2, 7, 6},
                                                                    {0, 2, 6},
                                                                    {0, 6, 4},
                                                                    {1, 5, 7},
                                                                    {1, 7, 3}}};

/// The centre of a mover's box.
glm::dvec3 center_of(const Patch& patch) {
  return glm::dmat3(patch.placement.linear) * patch.box_center + glm::dvec3(patch.placement.translation.v);
}

/// Whether `point` lies in the box of a mover, or within `margin` metres of it. The box is a parallelepiped,
/// which lies between three pairs of parallel planes.
bool may_contain(const Patch& patch, Point<Anchor> point, double margin) {
  const glm::dmat3 linear(patch.placement.linear);
  const glm::dvec3 from_center = point.v - center_of(patch);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 normal = glm::normalize(glm::cross(linear[(axis + 1) % 3], linear[(axis + 2) % 3]));
    const double half = std::abs(glm::dot(normal, linear[axis])) * patch.object_half[axis];
    if (std::abs(glm::dot(normal, from_center)) > half + margin) return false;
  }
  return true;
}

/// Appends the cells that the surface of a mover's box touches.
void cover_box(const CellFrame& frame, const Patch& patch, std::vector<CellTouch>& touched) {
  const glm::dmat3 linear(patch.placement.linear);
  std::array<Point<Anchor>, 8> corner;
  for (std::size_t i = 0; i < corner.size(); ++i) {
    const glm::dvec3 sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    corner[i] = {linear * (sign * patch.object_half) + center_of(patch)};
  }
  for (const auto& t : kBoxTriangles) cover(frame, {corner[t[0]], corner[t[1]], corner[t[2]]}, touched);
}

}  // namespace

LightVisibilityMap::LightVisibilityMap(const ShadowLight& light, const FacetPlanes& planes,
                                       const SurfaceModel& model)
    : light_(light), frame_(frame_for(light, planes.reach, model)), cells_(frame_.count()), planes_(1) {
  enter_fixed(planes, model);
  drop_unused_planes();
  place(model);
}

void LightVisibilityMap::enter_fixed(const FacetPlanes& planes, const SurfaceModel& model) {
  std::vector<std::uint32_t> known(planes.planes.size(), kUnasked);
  const auto local = [&](std::uint32_t id) {
    if (known[id] != kUnasked) return known[id];
    const FacetPlane& p = planes.planes[id];
    const int side = side_of(p, light_, planes.reach);
    if (side == 0) return known[id] = kEdgeOn;
    const glm::vec3 n = side > 0 ? p.normal : -p.normal;
    planes_.push_back({n.x, n.y, n.z, side > 0 ? p.high : -p.low, p.doubt});
    return known[id] = static_cast<std::uint32_t>(planes_.size() - 1);
  };
  std::vector<CellTouch> touched;
  const auto enter_triangle = [&](std::uint32_t t) {
    touched.clear();
    cover(frame_, corners_of(model, t), touched);
    const std::uint32_t id = planes.of_triangle[t];
    const std::uint32_t plane = id == kNoPlane ? kEdgeOn : local(id);
    for (const CellTouch& touch : touched) {
      Cell& cell = cells_[touch.cell];
      if (plane == kEdgeOn)
        cell.rest = std::min(cell.rest, touch.depth);
      else
        enter(cell, plane, touch.depth);
    }
  };
  for (const Patch& patch : model.patches().first(model.fixed_count()))
    for (std::uint32_t i = 0; patch.casts && i < patch.triangle_count; ++i)
      enter_triangle(patch.first_triangle + i);
}

void LightVisibilityMap::drop_unused_planes() {
  std::vector<std::uint32_t> renumbered(planes_.size(), 0);
  std::vector<Plane> used(1);
  for (Cell& cell : cells_)
    for (std::size_t i = 0; i < kPlanes && cell.from[i] < kFar; ++i) {
      std::uint32_t& number = renumbered[cell.plane[i]];
      if (number == 0) {
        number = static_cast<std::uint32_t>(used.size());
        used.push_back(planes_[cell.plane[i]]);
      }
      cell.plane[i] = number;
    }
  used.shrink_to_fit();
  planes_ = std::move(used);
}

void LightVisibilityMap::place(const SurfaceModel& model) {
  for (const std::uint32_t cell : moving_cells_) cells_[cell].moving = kFar;
  moving_cells_.clear();
  std::vector<CellTouch> touched;
  for (const Patch& patch : model.patches().subspan(model.fixed_count())) {
    if (patch.placement.singular || !patch.casts) continue;
    CellFrame frame = frame_;
    frame.rounding =
        std::max(frame.rounding, kRounding * kUlp * double{patch.placement.reach + light_.reach});
    if (frame.cube && may_contain(patch, frame.origin, frame.rounding)) {
      // From inside a box, its surface is its far end: the mover may stand before it in every direction.
      for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) touched.push_back({cell, 0.0f});
      continue;
    }
    cover_box(frame, patch, touched);
  }
  for (const CellTouch& touch : touched) {
    float& moving = cells_[touch.cell].moving;
    if (moving == kFar) moving_cells_.push_back(touch.cell);
    moving = std::min(moving, touch.depth);
  }
}

bool LightVisibilityMap::is_of(const ShadowLight& light) const {
  return light.kind == light_.kind && light.position == light_.position &&
         light.direction == light_.direction;
}

std::size_t LightVisibilityMap::bytes() const {
  return cells_.capacity() * sizeof(Cell) + planes_.capacity() * sizeof(Plane) +
         moving_cells_.capacity() * sizeof(std::uint32_t);
}

}  // namespace farshade
