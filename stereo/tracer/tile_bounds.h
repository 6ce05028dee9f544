/// What one light does to a whole tile, if it can be told from the tile's bounds without its single pixels.
/// The verdicts are certain, so masks have the same bits with and without them. A group of blocks from
/// several tiles is judged in the same way, by the bounds of its covered pixels.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "stereo/tracer/lanes.h"
#include "stereo/tracer/light_visibility_map.h"
#include "stereo/tracer/tile_surface.h"

namespace farshade {

/// OutOfRange, OutOfCone, TurnedAway: this condition of a set bit holds in no pixel of the tile. Lit: all
/// conditions hold in all of its pixels. Open: neither is certain.
enum class TileVerdict : std::uint8_t { Open, OutOfRange, OutOfCone, TurnedAway, Lit };

struct Box {
  glm::vec3 low{kFar}, high{-kFar};
};

/// Bounds of a tile's covered pixels, in anchor space.
struct TileBounds {
  Box points, starts;   ///< of the surfaces, and of the starts of their shadow rays
  Box shading, facet;   ///< of the shading and the geometric normals
  float reach = 0;      ///< the largest
  float along = -kFar;  ///< if all geometric normals are equal: the least dot(normal, start)
};

/// Least and largest of `values` in covered pixels, those with a reach above 0.
inline void span_of(const float (&values)[kTilePixels], const TileSurface& s, float& low, float& high) {
  constexpr int kWide = 8;
  const Floats<kWide> far = kFar - Floats<kWide>{};
  Floats<kWide> least = far, most = -far;
  for (int first = 0; first < s.pixels; first += kWide) {
    Floats<kWide> value, size;
    load(value, values + first), load(size, s.reach + first);
    const Floats<kWide> for_least = size > 0 ? value : far, for_most = size > 0 ? value : -far;
    least = for_least < least ? for_least : least;
    most = for_most > most ? for_most : most;
  }
  low = least[0], high = most[0];
  for (int i = 1; i < kWide; ++i) low = std::min(low, least[i]), high = std::max(high, most[i]);
}

inline Box box_of(const float (&x)[kTilePixels], const float (&y)[kTilePixels], const float (&z)[kTilePixels],
                  const TileSurface& s) {
  Box box;
  span_of(x, s, box.low.x, box.high.x);
  span_of(y, s, box.low.y, box.high.y);
  span_of(z, s, box.low.z, box.high.z);
  return box;
}

/// `s` has covered pixels.
inline TileBounds bounds_of(const TileSurface& s) {
  TileBounds b{.points = box_of(s.px, s.py, s.pz, s),
               .starts = box_of(s.ox, s.oy, s.oz, s),
               .shading = box_of(s.nx, s.ny, s.nz, s),
               .facet = box_of(s.gx, s.gy, s.gz, s)};
  float least;
  span_of(s.reach, s, least, b.reach);
  if (b.facet.low != b.facet.high) return b;
  float along[kTilePixels];
  const glm::vec3 g = b.facet.low;
  for (int i = 0; i < s.pixels; ++i) along[i] = g.x * s.ox[i] + g.y * s.oy[i] + g.z * s.oz[i];
  span_of(along, s, b.along, least);
  return b;
}

/// Relative margin of distances and products, for the rounding here and in a pixel's own test: about 170 u,
/// for fewer than ten roundings. Half or twice as much only changes how many tiles are judged at once.
inline constexpr float kCullSlack = 1e-5f;

/// The least dot(n, x) of all x in a box.
inline float least_along(const glm::vec3& n, const Box& box) {
  float least = 0;
  for (int axis = 0; axis < 3; ++axis) least += std::min(n[axis] * box.low[axis], n[axis] * box.high[axis]);
  return least;
}

/// 1 = dot(n, l) is certainly positive for all n and l in the boxes, -1 = certainly for none, 0 = uncertain.
inline int facing(const Box& n, const Box& l) {
  float least = 0, most = 0, size = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = n.low[axis] * l.low[axis], b = n.low[axis] * l.high[axis];
    const float c = n.high[axis] * l.low[axis], d = n.high[axis] * l.high[axis];
    const float low = std::min({a, b, c, d}), high = std::max({a, b, c, d});
    least += low, most += high;
    size += std::max(std::abs(low), std::abs(high));
  }
  return least > kCullSlack * size ? 1 : most < -kCullSlack * size ? -1 : 0;
}

/// Signed distance of the bounding sphere of `points` from a spot light's cone, for cones of up to 90 degrees
/// from their axis. `sign` 1: of the sphere's nearest point, so that a positive result means all is outside.
/// `sign` -1: of its farthest point, so that a negative result means all is inside.
inline float outside_cone(const Box& points, const ShadowLight& light, float sign) {
  const glm::vec3 v = (points.low + points.high) * 0.5f - light.position.v;
  const float radius = glm::length(points.high - points.low) * 0.5f;
  const glm::vec3& axis = light.direction.v;
  const float along = glm::dot(v, axis), across = glm::length(glm::cross(v, axis));
  const float sin_outer = std::sqrt(std::max(1 - light.cos_outer * light.cos_outer, 0.0f));
  const float slack = radius + kCullSlack * (radius + glm::length(v) + light.reach);
  return across * light.cos_outer - along * sin_outer - sign * slack;
}

/// Whether all shadow rays of the tile start on the light's side of the plane.
inline bool is_before(const TileBounds& b, const LightVisibilityMap::Plane& plane) {
  const glm::vec3 n(plane.nx, plane.ny, plane.nz);
  const float own = b.along + least_along(n - b.facet.low, b.starts);
  const float above = std::max(least_along(n, b.starts), own) - plane.offset;
  return above >= std::max(plane.doubt, 0.5f * kOffset * b.reach) + 0.125f * kOffset * b.reach;
}

/// The cells that a box touches: columns left to right and rows top to bottom, inclusive; and its largest
/// depth. Empty if right < left or bottom < top.
struct CellRect {
  int face = 0, left = 0, right = -1, top = 0, bottom = -1;
  float depth = 0;

  [[nodiscard]] int count() const { return (right - left + 1) * (bottom - top + 1); }
};

/// The range of cells from coordinate `low` to `high`, widened by 1/64 cell for rounding. Leaves `first` and
/// `last` as they are if the range leaves the face.
inline void cells_between(float low, float high, int side, int& first, int& last) {
  constexpr float kWider = 1.0f / 64;
  if (!(low >= -kWider && high <= static_cast<float>(side) + kWider)) return;
  first = std::max(static_cast<int>(low - kWider + 1) - 1, 0);
  last = std::min(static_cast<int>(high + kWider), side - 1);
}

/// Empty if the box is not in front of a single face.
inline CellRect cells_of(const CellFrame& frame, const Box& box) {
  CellRect rect;
  const glm::vec3 origin(frame.origin.v), low = box.low - origin, high = box.high - origin;
  const glm::vec3 middle = (low + high) * 0.5f, half = (high - low) * 0.5f;
  const float half_side = static_cast<float>(frame.side) * 0.5f;
  if (!frame.cube) {
    const auto reach_of = [&](const glm::dvec3& row, float& centre, float& extent) {
      const glm::vec3 r(row);
      centre = glm::dot(r, middle), extent = glm::dot(glm::abs(r), half);
    };
    float u, du, v, dv, depth, deeper;
    reach_of(frame.rows[0], u, du), reach_of(frame.rows[1], v, dv), reach_of(frame.rows[2], depth, deeper);
    cells_between(u - du + half_side, u + du + half_side, frame.side, rect.left, rect.right);
    cells_between(v - dv + half_side, v + dv + half_side, frame.side, rect.top, rect.bottom);
    rect.depth = depth + deeper + kOffset * 0.125f * (std::abs(depth) + deeper);
    return rect;
  }
  const glm::vec3 size = glm::abs(middle);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const int x = axis == 0 ? 1 : 0, y = axis == 2 ? 1 : 2;
  const bool against = middle[axis] < 0;
  const float near = against ? -high[axis] : low[axis], far = against ? -low[axis] : high[axis];
  if (!(near > 0)) return rect;
  const auto least = [&](float value) { return half_side * value / (value < 0 ? near : far) + half_side; };
  const auto most = [&](float value) { return half_side * value / (value < 0 ? far : near) + half_side; };
  rect.face = 2 * axis + (against ? 1 : 0);
  // A point beyond the face's sides belongs to another face.
  if (std::max({-low[x], high[x], -low[y], high[y]}) > near) return rect;
  cells_between(least(low[x]), most(high[x]), frame.side, rect.left, rect.right);
  cells_between(least(low[y]), most(high[y]), frame.side, rect.top, rect.bottom);
  rect.depth = far * (1 + kCullSlack);
  return rect;
}

/// Whether no occluder in the map can lie between any pixel of the tile and the light.
inline bool is_clear(const LightVisibilityMap& map, const TileBounds& b) {
  constexpr int kMostCells = 8;
  const CellRect rect = cells_of(map.frame(), b.starts);
  if (rect.right < rect.left || rect.bottom < rect.top || rect.count() > kMostCells) return false;
  const int side = map.frame().side;
  for (int row = rect.top; row <= rect.bottom; ++row)
    for (int column = rect.left; column <= rect.right; ++column) {
      const auto number = static_cast<std::size_t>((rect.face * side + row) * side + column);
      const LightVisibilityMap::Cell& cell = map.cells()[number];
      if (!(rect.depth < std::min(cell.rest, cell.moving))) return false;
      for (std::size_t k = 0; k < LightVisibilityMap::kPlanes && cell.from[k] < kFar; ++k)
        if (!(rect.depth < cell.from[k]) && !is_before(b, map.planes()[cell.plane[k]])) return false;
    }
  return true;
}

/// `map` is the light's map, or null.
inline TileVerdict verdict_on(const TileBounds& b, const ShadowLight& light, const LightVisibilityMap* map) {
  Box to_light{-light.direction.v, -light.direction.v};
  bool all = map != nullptr;
  if (light.kind != LightKind::Directional) {
    to_light = {light.position.v - b.points.high, light.position.v - b.points.low};
    const glm::vec3 outside = glm::max(glm::max(to_light.low, -to_light.high), glm::vec3(0.0f));
    if (glm::length(outside) > light.range * (1 + kCullSlack)) return TileVerdict::OutOfRange;
    const float farthest = glm::length(glm::max(glm::abs(to_light.low), glm::abs(to_light.high)));
    all = all && farthest < light.range * (1 - kCullSlack);
    if (light.cos_outer >= 0) {
      if (outside_cone(b.points, light, 1) > 0) return TileVerdict::OutOfCone;
      all = all && outside_cone(b.points, light, -1) < 0;
    } else {
      all = all && light.cos_outer < -1;
    }
  }
  const int by_shading = facing(b.shading, to_light), by_facet = facing(b.facet, to_light);
  if (by_shading < 0 || by_facet < 0) return TileVerdict::TurnedAway;
  all = all && by_shading > 0 && by_facet > 0;
  return all && is_clear(*map, b) ? TileVerdict::Lit : TileVerdict::Open;
}

}  // namespace farshade
