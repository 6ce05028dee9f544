/// Placed surfaces: what a tile sees, from positions that someone else has found and rounded to a grid.
///
/// A rounded position lies up to E = step sqrt(3) / 2 before or behind its surface, and a ray from it to the
/// light would meet that surface. So rays start above it. A start lifted by h = E / cos a along a direction
/// that is tilted by at most a against the surface's normal is on the light's side, however the light grazes:
/// h cos a >= E. What float rounds is added as in tile_stages.h.
///
/// A difference of two positions is wrong by at most D = 2 E. So a normal across differences p and q, of
/// which p is the longer and r is the height of q over p, is tilted by at most a = asin(D / |p|) +
/// asin(D / r). Neighbours 1, 2, 4 and 8 pixels away are tried until |p| and r are at least 2 D: a <= 60
/// degrees, and less than the eye stands off that plane, so that its seen side is known. Where they all lie
/// in one plane, this is the direction. At edges and on what is curved the normal may be another surface's;
/// but the way to the eye is on the seen side of whatever is seen. So the lift goes there, by E / cos of its
/// angle to that normal, up to 8 E; by 2 E where no neighbours tell anything.
#pragma once

#include "stereo/frame/position_grid.h"
#include "stereo/tracer/tile_stages.h"

namespace farshade {

/// One eye's positions.
struct PlacedEye {
  const PositionPlanes& planes;
  glm::dvec3 low;       ///< of the grid, anchor-relative
  double step = 0;      ///< metres
  glm::vec3 eye{0.0f};  ///< anchor-relative
  float reach = 0;      ///< largest absolute coordinate of what can occlude
};

/// Normals are the directions of the lifts.
struct PlacedSurface : TileSurface {
  /// Upper bound of a's sine where neighbours lie in one plane about the pixel; else above 1: the light may
  /// be on the seen side wherever it stands.
  float tilt[kTilePixels];
};

void place_tile(const PlacedEye& eye, const TileRect& rect, PlacedSurface& out);

/// Only what is certainly turned away is left out: behind its own surface it is dark either way.
template <int K>
void set_facing(const PlacedSurface& s, int first, LightWay<K>& way) {
  Floats<K> nx, ny, nz, tilt;
  load(nx, s.nx + first), load(ny, s.ny + first), load(nz, s.nz + first), load(tilt, s.tilt + first);
  way.faces = nx * way.x + ny * way.y + nz * way.z > -tilt * way.distance;
}

}  // namespace farshade
