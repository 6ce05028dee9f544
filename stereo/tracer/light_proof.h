/// The proof for a packet of pixels: which of them lie in front of all occluders in the light's map. The
/// proof is certain, so masks have the same bits with and without it.
#pragma once

#include "stereo/tracer/lanes.h"
#include "stereo/tracer/light_visibility_map.h"
#include "stereo/tracer/tile_surface.h"

namespace farshade {

/// The cells and depths at which a packet's rays start.
template <int K>
struct CellLanes {
  Ints<K> cell;  ///< -1 beside the map
  Floats<K> depth;
};

template <int K>
void find_on_cube(const CellFrame& frame, const TileSurface& s, int first, CellLanes<K>& found) {
  Floats<K> x, y, z;
  load(x, s.ox + first), load(y, s.oy + first), load(z, s.oz + first);
  x -= static_cast<float>(frame.origin.v.x);
  y -= static_cast<float>(frame.origin.v.y);
  z -= static_cast<float>(frame.origin.v.z);
  const Floats<K> ax = x < 0 ? -x : x, ay = y < 0 ? -y : y, az = z < 0 ? -z : z;
  const Ints<K> is_x = (ax >= ay) & (ax >= az), is_y = ~is_x & (ay >= az), is_z = ~(is_x | is_y);
  const Floats<K> along = is_x ? x : is_y ? y : z, u = is_x ? y : x, v = is_z ? y : z;
  found.depth = is_x ? ax : is_y ? ay : az;
  const float half = static_cast<float>(frame.side) * 0.5f, last = static_cast<float>(frame.side - 1);
  const Floats<K> scale = half / found.depth;
  Floats<K> column = u * scale + half, row = v * scale + half;
  column = column > 0 ? column : Floats<K>{}, row = row > 0 ? row : Floats<K>{};
  const Floats<K> end = last - Floats<K>{};
  column = column < last ? column : end, row = row < last ? row : end;
  const Ints<K> face = (is_y & 2) + (is_z & 4) + ((along < 0) & 1);
  found.cell = (face * frame.side + __builtin_convertvector(row, Ints<K>)) * frame.side +
               __builtin_convertvector(column, Ints<K>);
}

template <int K>
void find_across(const CellFrame& frame, const TileSurface& s, int first, CellLanes<K>& found) {
  Floats<K> x, y, z;
  load(x, s.ox + first), load(y, s.oy + first), load(z, s.oz + first);
  x -= static_cast<float>(frame.origin.v.x);
  y -= static_cast<float>(frame.origin.v.y);
  z -= static_cast<float>(frame.origin.v.z);
  const glm::vec3 across(frame.rows[0]), down(frame.rows[1]), along(frame.rows[2]);
  const float half = static_cast<float>(frame.side) * 0.5f, side = static_cast<float>(frame.side);
  const Floats<K> u = across.x * x + across.y * y + across.z * z + half;
  const Floats<K> v = down.x * x + down.y * y + down.z * z + half;
  const Ints<K> inside = (u >= 0) & (v >= 0) & (u < side) & (v < side);
  const Floats<K> none = Floats<K>{};
  const Floats<K> column = inside ? u : none, row = inside ? v : none;
  found.cell =
      (__builtin_convertvector(row, Ints<K>) * frame.side + __builtin_convertvector(column, Ints<K>)) |
      ~inside;
  found.depth = along.x * x + along.y * y + along.z * z;
}

/// Sets `proven` to -1 in those of `lanes` from which the light is certainly visible, and to 0 in the others.
/// Visits each of their cells once.
template <int K>
void prove(const LightVisibilityMap& map, const TileSurface& s, int first, const Ints<K>& lanes,
           Ints<K>& proven) {
  CellLanes<K> found;
  if (map.frame().cube)
    find_on_cube<K>(map.frame(), s, first, found);
  else
    find_across<K>(map.frame(), s, first, found);
  Floats<K> x, y, z, doubt;
  load(x, s.ox + first), load(y, s.oy + first), load(z, s.oz + first), load(doubt, s.reach + first);
  doubt *= 0.5f * kOffset;
  Ints<K> pending = lanes & (found.cell >= 0);
  proven = Ints<K>{};
  for (int lead = first_of(pending); lead >= 0; lead = first_of(pending)) {
    const std::int32_t number = found.cell[lead];
    const LightVisibilityMap::Cell& cell = map.cells()[static_cast<std::size_t>(number)];
    Ints<K> clear = pending & (found.cell == number);
    pending &= ~clear;
    clear &= found.depth < std::min(cell.rest, cell.moving);
    for (std::size_t k = 0; k < LightVisibilityMap::kPlanes && cell.from[k] < kFar; ++k) {
      const LightVisibilityMap::Plane& plane = map.planes()[cell.plane[k]];
      const Floats<K> above = x * plane.nx + (y * plane.ny + (z * plane.nz - plane.offset));
      clear &= (found.depth < cell.from[k]) | ((above >= doubt) & (above >= plane.doubt));
    }
    proven |= clear;
  }
}

}  // namespace farshade
