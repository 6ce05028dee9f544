/// What of a tile a light cannot reach, and where nothing can come between: found before any ray is traced,
/// and certain, so that masks are the same bits with it and without.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>

#include "stereo/tracer/light_map.h"
#include "stereo/tracer/tile_surface.h"

namespace farshade {

/// Why a light does not matter anywhere in a tile.
enum class Misses : std::uint8_t { No, Range, Cone, Facing };

/// Boxes about a tile's covered pixels: where they are, and their normals.
struct TileBounds {
  glm::vec3 low{kFar}, high{-kFar};
  glm::vec3 shading_low{kFar}, shading_high{-kFar};
  glm::vec3 facet_low{kFar}, facet_high{-kFar};
};

/// Of a tile with covered pixels.
inline TileBounds bounds_of(const TileSurface& s) {
  TileBounds b;
  const auto span = [&s](const float(&values)[kTilePixels], float& low, float& high) {
    float least = kFar, most = -kFar;
    for (int i = 0; i < kTilePixels; ++i) {
      const bool covered = s.reach[i] > 0;
      least = std::min(least, covered ? values[i] : kFar);
      most = std::max(most, covered ? values[i] : -kFar);
    }
    low = least, high = most;
  };
  span(s.px, b.low.x, b.high.x), span(s.py, b.low.y, b.high.y), span(s.pz, b.low.z, b.high.z);
  span(s.nx, b.shading_low.x, b.shading_high.x), span(s.ny, b.shading_low.y, b.shading_high.y);
  span(s.nz, b.shading_low.z, b.shading_high.z);
  span(s.gx, b.facet_low.x, b.facet_high.x), span(s.gy, b.facet_low.y, b.facet_high.y);
  span(s.gz, b.facet_low.z, b.facet_high.z);
  return b;
}

/// Of distances and products, for what float loses in a pixel's own test.
inline constexpr float kCullSlack = 1e-5f;

/// Whether dot(n, l) is positive for no n and l of the two boxes.
inline bool turned_away(const glm::vec3& n_low, const glm::vec3& n_high, const glm::vec3& l_low,
                        const glm::vec3& l_high) {
  float most = 0, size = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = n_low[axis] * l_low[axis], b = n_low[axis] * l_high[axis];
    const float c = n_high[axis] * l_low[axis], d = n_high[axis] * l_high[axis];
    most += std::max({a, b, c, d});
    size += std::max({std::abs(a), std::abs(b), std::abs(c), std::abs(d)});
  }
  return most < -kCullSlack * size;
}

/// Conservative: No may be said of a light that matters nowhere.
inline Misses misses(const TileBounds& b, const ShadowLight& light) {
  glm::vec3 to_light_low = -light.direction, to_light_high = -light.direction;
  if (light.kind != LightKind::Directional) {
    to_light_low = light.position - b.high, to_light_high = light.position - b.low;
    const glm::vec3 outside = glm::max(glm::max(to_light_low, -to_light_high), glm::vec3(0.0f));
    if (glm::length(outside) > light.range * (1 + kCullSlack)) return Misses::Range;
    if (light.cos_outer > 0) {
      const glm::vec3 v = (to_light_low + to_light_high) * -0.5f;  // to the ball about the box
      const float radius = glm::length(b.high - b.low) * 0.5f, distance = glm::length(v);
      const float along = glm::dot(v, light.direction);
      const float across = glm::length(glm::cross(v, light.direction));
      const float sin_outer = std::sqrt(std::max(1 - light.cos_outer * light.cos_outer, 0.0f));
      if (across * light.cos_outer - along * sin_outer > radius + kCullSlack * (radius + distance))
        return Misses::Cone;
    }
  }
  if (turned_away(b.shading_low, b.shading_high, to_light_low, to_light_high) ||
      turned_away(b.facet_low, b.facet_high, to_light_low, to_light_high))
    return Misses::Facing;
  return Misses::No;
}

/// The cells in which K rays' starts lie, and their depths; -1 where the map does not go.
template <int K>
void find_cells(const CellFrame& frame, const TileSurface& s, int first, std::int32_t (&cell)[K],
                float (&depth)[K]) {
  const glm::vec3 origin(frame.origin);
  const float half = static_cast<float>(frame.side) * 0.5f;
  const std::int32_t side = frame.side, last = side - 1, face_cells = side * side;
  if (frame.cube) {
    for (int i = 0; i < K; ++i) {
      const float x = s.ox[first + i] - origin.x, y = s.oy[first + i] - origin.y,
                  z = s.oz[first + i] - origin.z;
      const float ax = std::abs(x), ay = std::abs(y), az = std::abs(z);
      const bool is_x = (ax >= ay) & (ax >= az), is_y = !is_x & (ay >= az);
      const float along = is_x ? x : is_y ? y : z;
      const float w = std::abs(along), u = is_x ? y : x, v = is_x | is_y ? z : y;
      const float scale = half / w;
      const std::int32_t face = (is_x ? 0 : is_y ? 2 : 4) + (along < 0 ? 1 : 0);
      const auto column = static_cast<std::int32_t>(std::min(u * scale + half, 32767.0f));
      const auto row = static_cast<std::int32_t>(std::min(v * scale + half, 32767.0f));
      cell[i] = face * face_cells + std::clamp(row, 0, last) * side + std::clamp(column, 0, last);
      depth[i] = w;
    }
    return;
  }
  const std::array<glm::vec3, 3> rows{glm::vec3(frame.rows[0]), glm::vec3(frame.rows[1]),
                                      glm::vec3(frame.rows[2])};
  for (int i = 0; i < K; ++i) {
    const float x = s.ox[first + i] - origin.x, y = s.oy[first + i] - origin.y,
                z = s.oz[first + i] - origin.z;
    const float u = rows[0].x * x + rows[0].y * y + rows[0].z * z + half;
    const float v = rows[1].x * x + rows[1].y * y + rows[1].z * z + half;
    const auto end = static_cast<float>(side);
    const bool inside = (u >= 0) & (v >= 0) & (u < end) & (v < end);
    const auto column = static_cast<std::int32_t>(inside ? u : 0.0f);
    const auto row = static_cast<std::int32_t>(inside ? v : 0.0f);
    cell[i] = inside ? row * side + column : -1;
    depth[i] = rows[2].x * x + rows[2].y * y + rows[2].z * z;
  }
}

/// `proven` becomes -1 in those of `lanes` whose light nothing can hide. A packet is looked up in as many
/// cells as most have; what lies in further ones is not proven.
template <int K>
void prove(const LightMap& map, const TileSurface& s, int first, const Lanes<K>& lanes, Lanes<K>& proven) {
  constexpr int kMostCells = 4;
  alignas(4 * K) std::int32_t cell[K];
  alignas(4 * K) float depth[K];
  find_cells<K>(map.frame(), s, first, cell, depth);
  alignas(4 * K) std::int32_t pending[K];
  for (int i = 0; i < K; ++i) pending[i] = lanes.valid[i] & (cell[i] >= 0 ? -1 : 0);
  for (int i = 0; i < K; ++i) proven.valid[i] = 0;
  for (int turn = 0; turn < kMostCells; ++turn) {
    std::uint32_t bits = 0;
    for (int i = 0; i < K; ++i) bits |= (pending[i] != 0 ? 1u : 0u) << i;
    if (bits == 0) return;
    const std::int32_t number = cell[std::countr_zero(bits)];
    const LightMap::Cell& here = map.cells()[static_cast<std::size_t>(number)];
    const float open = std::min(here.rest, here.moving);
    alignas(4 * K) std::int32_t clear[K];
    for (int i = 0; i < K; ++i) {
      const std::int32_t in_cell = pending[i] & (cell[i] == number ? -1 : 0);
      clear[i] = in_cell & (depth[i] < open ? -1 : 0);
      pending[i] &= ~in_cell;
    }
    for (std::size_t k = 0; k < LightMap::kPlanes; ++k) {
      if (here.from[k] == kFar) continue;
      const LightMap::Plane& plane = map.planes()[here.plane[k]];
      for (int i = 0; i < K; ++i) {
        const int at = first + i;
        const float above =
            plane.nx * s.ox[at] + (plane.ny * s.oy[at] + (plane.nz * s.oz[at] - plane.offset));
        const bool before =
            (depth[i] < here.from[k]) | (above >= std::max(plane.doubt, 0.5f * kOffset * s.reach[at]));
        clear[i] &= before ? -1 : 0;
      }
    }
    for (int i = 0; i < K; ++i) proven.valid[i] |= clear[i];
  }
}

}  // namespace farshade
