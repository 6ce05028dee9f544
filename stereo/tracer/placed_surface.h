/// Placed surfaces: the surfaces of a tile's pixels, from positions that the client has found and rounded to
/// a grid.
///
/// A rounded position lies up to E = step sqrt(3) / 2 off its surface, so a ray from there to the light could
/// hit that surface. But the surface lies on the pixel's own ray, which is known. The position is projected
/// onto that ray; its error there is at most E. It is then moved by E towards the eye. So it lies 0 to 2 E
/// before the surface, on the side that the eye sees, at any angle of eye and light. Nothing else lies there,
/// since the eye sees through. So rounding to the grid needs no normal.
///
/// Against rounding of float, the start is lifted as in tile_stages.h, along a normal that is estimated from
/// the differences p and q to neighbouring positions. Let p be the longer one, and r the height of q over p.
/// A difference is wrong by at most D = 2 E, so the normal is tilted by at most asin(D / |p|) + asin(D / r).
/// Neighbours 1, 2, 4 and 8 pixels away are tried until this tilt is below 60 degrees and below the angle
/// between the plane and the direction to the eye. If the neighbours lie in no such plane, the start is
/// lifted towards the eye.
#pragma once

#include "stereo/frame/position_grid.h"
#include "stereo/tracer/tile_stages.h"

namespace farshade {

/// The positions of one eye's pixels.
struct PlacedEye {
  const PositionPlanes& planes;
  Point<Anchor> low;  ///< lowest corner of the grid
  double step = 0;    ///< of the grid, metres
  ViewRays rays;      ///< the pixels' rays, on which the surfaces lie
  float reach = 0;    ///< largest absolute coordinate of any occluder
};

/// Both normals are the direction in which the ray's start is lifted.
struct PlacedSurface : TileSurface {
  /// Upper bound of the sine of the normal's tilt, if the neighbours lie in one plane with the pixel.
  /// Otherwise above 1: the light may be on the seen side wherever it is.
  float tilt[kTilePixels];
};

/// Computes the surfaces of the pixels of `rect`.
void place_tile(const PlacedEye& eye, const TileRect& rect, PlacedSurface& out);

/// Skips only pixels that are certainly turned away. The bit of a light behind the surface may have either
/// value.
template <int K>
void set_facing(const PlacedSurface& s, int first, LightGeometry<K>& to_light) {
  Floats<K> nx, ny, nz, tilt;
  load(nx, s.nx + first), load(ny, s.ny + first), load(nz, s.nz + first), load(tilt, s.tilt + first);
  to_light.faces = nx * to_light.x + ny * to_light.y + nz * to_light.z > -tilt * to_light.distance;
}

}  // namespace farshade
