/// Placed surfaces: what a tile sees, from positions that someone else has found and rounded to a grid.
///
/// A rounded position lies up to E = step sqrt(3) / 2 beside its surface, and a ray from there to the light
/// could meet that surface. But the pixel's own ray is known, and the surface is on it: dropped onto that
/// ray, a position is wrong by at most E along it. Moved on by E towards the eye it is between 0 and 2 E
/// before the surface, on the side that is seen, however eye and light graze; nothing stands there, since the
/// eye sees past it. So no normal is needed against rounding to the grid.
///
/// Against rounding of float the start is lifted as in tile_stages.h, along a normal across differences p and
/// q of neighbouring positions, of which p is the longer and r is the height of q over p. A difference is
/// wrong by at most D = 2 E, so the normal is tilted by at most asin(D / |p|) + asin(D / r). Neighbours 1, 2,
/// 4 and 8 pixels away are tried until that is below 60 degrees and below what the eye stands off the plane.
/// Where neighbours are in no such plane, the lift is towards the eye.
#pragma once

#include "stereo/frame/position_grid.h"
#include "stereo/tracer/tile_stages.h"

namespace farshade {

/// One eye's positions.
struct PlacedEye {
  const PositionPlanes& planes;
  glm::dvec3 low;   ///< of the grid, anchor-relative
  double step = 0;  ///< metres
  ViewRays rays;    ///< on which they were found
  float reach = 0;  ///< largest absolute coordinate of what can occlude
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
