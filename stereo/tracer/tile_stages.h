/// The two stages of a group of blocks (block_groups.h). Their buffers stay in the first-level cache in
/// between.
///
/// see_group finds the nearest surface of each pixel. shadow_group finds which of these surfaces one light
/// reaches.
///
/// The offset of a shadow ray from its surface is a multiple of the unit in the last place, as in C. Waechter
/// and N. Binder, "A fast and robust method for avoiding self-intersection", Ray Tracing Gems I, chapter 6,
/// but of the largest coordinate M of the triangle, and the multiple is derived. With u = 2^-24, the errors
/// of a distance to the surface's plane are at most, in u M:
///
/// - 8.7: barycentric sum of the hit point; 2 (weights do not sum to 1) + 3 per coordinate, times sqrt 3
/// - 1.7: addition of the offset; 1 per coordinate
/// - 3.5: Embree's vertices minus the origin, |v - o| <= 2M per coordinate, rounded
/// - 10.4: Embree's dot product of that and the normal; 3 roundings of 2 sqrt 3 M
/// - 10: Embree's normal, from edges of such vertices (4 u M) and a cross product, for a well-shaped triangle
///
/// These are 35 u M together. 64 u M leaves room for triangles whose height is a few times smaller than their
/// longest edge. Therefore an occluder closer than 2^-18 of the largest coordinate to a surface may fail to
/// cast on it.
///
/// Rays start at the surface and end at the light. Packets that start at the light were 0 to 3 % faster in
/// three scenes, but then the light's coordinates would count into M.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>

#include "stereo/frame/view.h"
#include "stereo/math/fov.h"
#include "stereo/tracer/block_groups.h"
#include "stereo/tracer/lanes.h"
#include "stereo/tracer/ray_scene.h"
#include "stereo/tracer/shadow_light.h"
#include "stereo/tracer/tile_surface.h"

namespace farshade {

/// Primary rays of a view: the ray through pixel position (x, y) has the direction corner + x across + y
/// down. Directions are the same in the stage and in anchor space.
struct ViewRays {
  Extent size;  ///< of the view, pixels
  FloatPoint<Anchor> origin;
  glm::dvec3 corner, across, down;
};

inline ViewRays rays_of(const View& view, const Rigid<Anchor, Stage>& anchor_from_stage) {
  const FovTangents window = tangents_of(view.fov);
  const auto stage_ray = [&](double x, double y) {
    return view.stage_from_eye(Vector<Eye>{pixel_ray(window, view.size, {x, y})}).v;
  };
  const glm::dvec3 corner = stage_ray(0, 0);
  const Point<Stage> eye{view.stage_from_eye.translation};
  return {view.size, in_float(anchor_from_stage(eye)), corner, stage_ray(1, 0) - corner,
          stage_ray(0, 1) - corner};
}

/// Writes the surface that one ray has hit into pixel `at` of `out`.
inline void resolve_hit(const SurfaceModel& model, std::uint32_t patch_number, std::uint32_t primitive,
                        float u, float v, const glm::vec3& ray, TileSurface& out, int at) {
  const Patch& patch = model.patches()[patch_number];
  const std::size_t number = patch.first_triangle + primitive;
  const glm::uvec3& t = model.triangles()[number];
  const Facet& facet = model.facets()[number];
  const float w = 1.0f - u - v;
  const auto mix = [&](std::span<const glm::vec3> of) { return of[t.x] * w + of[t.y] * u + of[t.z] * v; };
  glm::vec3 p = mix(model.positions()), n = mix(model.normals()), g = facet.normal;
  float reach = facet.reach;
  if (patch.moving) {
    const Placement& placement = patch.placement;
    p = placement(p);
    n = placement.normal * n;
    g = placement.normal * g;
    const float length = glm::length(g);
    if (length > 0) g /= length;
    reach = placement.reach;
  }
  if (patch.double_sided && glm::dot(ray, g) > 0) n = -n, g = -g;
  out.px[at] = p.x, out.py[at] = p.y, out.pz[at] = p.z;
  const float offset = kOffset * reach;
  out.ox[at] = p.x + g.x * offset, out.oy[at] = p.y + g.y * offset, out.oz[at] = p.z + g.z * offset;
  out.nx[at] = n.x, out.ny[at] = n.y, out.nz[at] = n.z;
  out.gx[at] = g.x, out.gy[at] = g.y, out.gz[at] = g.z;
  out.reach[at] = reach;
}

/// Writes "not covered" into pixel `at` of `out`.
inline void resolve_miss(TileSurface& out, int at) {
  out.px[at] = out.py[at] = out.pz[at] = out.reach[at] = 0;
  out.ox[at] = out.oy[at] = out.oz[at] = 0;
  out.nx[at] = out.ny[at] = out.nz[at] = 0;
  out.gx[at] = out.gy[at] = out.gz[at] = 0;
}

/// Makes the primary rays of the packet that begins at pixel `first` of a block. They begin at the near
/// plane, where the rasteriser's picture begins, too: a direction's component along -z is 1. Lanes outside of
/// the view are not valid. A direction is computed from the corner of the block's tile, so it does not depend
/// on the group.
template <int K>
void aim_at_block(const ViewRays& view, BlockPlace block, int first, Lanes<K>& lanes, RayPacket<K>& ray) {
  const std::uint32_t in_tile_x = block.x % kTileSide_px, in_tile_y = block.y % kTileSide_px;
  const glm::vec3 corner(view.corner + view.across * (block.x - in_tile_x + 0.5) +
                         view.down * (block.y - in_tile_y + 0.5));
  const glm::vec3 across(view.across), down(view.down);
  for (int i = 0; i < K; ++i) {
    const TilePixel pixel = kTileOrder[static_cast<std::size_t>(first + i)];
    const auto x = static_cast<float>(in_tile_x + pixel.x), y = static_cast<float>(in_tile_y + pixel.y);
    lanes.valid[i] =
        ((block.x + pixel.x < view.size.width) & (block.y + pixel.y < view.size.height)) ? -1 : 0;
    ray.org_x[i] = view.origin.v.x, ray.org_y[i] = view.origin.v.y, ray.org_z[i] = view.origin.v.z;
    ray.dir_x[i] = corner.x + across.x * x + down.x * y;
    ray.dir_y[i] = corner.y + across.y * x + down.y * y;
    ray.dir_z[i] = corner.z + across.z * x + down.z * y;
    ray.tnear[i] = static_cast<float>(kNearPlane_m);
    ray.tfar[i] = kFar;
  }
}

/// Casts primary rays through the pixel centres of the blocks of `group`.
template <int K>
void see_group(const RayScene& scene, const SurfaceModel& model, const ViewRays& view,
               const BlockGroup& group, TileSurface& out) {
  RayHitPacket<K> packet;
  set_constants(packet.ray);
  out.pixels = group.count * kBlockPixels;
  out.covered = 0;
  for (int first = 0; first < out.pixels; first += K) {
    Lanes<K> lanes;
    const RayPacket<K>& ray = packet.ray;
    const BlockPlace block = group.blocks[static_cast<std::size_t>(first / kBlockPixels)];
    aim_at_block(view, block, first % kBlockPixels, lanes, packet.ray);
    scene.intersect(lanes, packet);
    for (int i = 0; i < K; ++i) {
      const HitPacket<K>& hit = packet.hit;
      if (hit.geometry[i] == kNothing) {
        resolve_miss(out, first + i);
        continue;
      }
      ++out.covered;
      resolve_hit(model, hit.geometry[i], hit.primitive[i], hit.u[i], hit.v[i],
                  {ray.dir_x[i], ray.dir_y[i], ray.dir_z[i]}, out, first + i);
    }
  }
}

/// Counts of those covered pixels of a group that are asked for in one light.
struct GroupRays {
  std::uint64_t traced = 0;
  /// Dark, without a ray; counted by the first condition that holds.
  std::uint64_t out_of_range = 0, out_of_cone = 0, away = 0;

  GroupRays& operator+=(const GroupRays& b) {
    traced += b.traced;
    out_of_range += b.out_of_range, out_of_cone += b.out_of_cone, away += b.away;
    return *this;
  }
  [[nodiscard]] std::uint64_t all() const { return traced + out_of_range + out_of_cone + away; }
};

/// The vectors from one packet's surfaces to the light, and the conditions of a set bit that need no ray.
template <int K>
struct LightGeometry {
  Floats<K> x, y, z, distance;  ///< from the surface to the light; a directional light: unit vectors
  Ints<K> covered, faces, in_range, in_cone;
};

/// Whether the light is on the seen side of both the shading and the geometric normal.
template <int K>
void set_facing(const TileSurface& s, int first, LightGeometry<K>& to_light) {
  Floats<K> nx, ny, nz, gx, gy, gz;
  load(nx, s.nx + first), load(ny, s.ny + first), load(nz, s.nz + first);
  load(gx, s.gx + first), load(gy, s.gy + first), load(gz, s.gz + first);
  to_light.faces = (nx * to_light.x + ny * to_light.y + nz * to_light.z > 0) &
                   (gx * to_light.x + gy * to_light.y + gz * to_light.z > 0);
}

/// Fills `to_light` for the packet that begins at pixel `first`.
template <int K, class Surface>
void face_light(const Surface& s, int first, const ShadowLight& light, LightGeometry<K>& to_light) {
  const glm::vec3& axis = light.direction.v;
  Floats<K>&x = to_light.x, &y = to_light.y, &z = to_light.z;
  load(x, s.px + first), load(y, s.py + first), load(z, s.pz + first);
  if (light.kind == LightKind::Directional)
    x = -axis.x - Floats<K>{}, y = -axis.y - Floats<K>{}, z = -axis.z - Floats<K>{};
  else
    x = light.position.v.x - x, y = light.position.v.y - y, z = light.position.v.z - z;
  to_light.distance = x * x + y * y + z * z;
  for (int i = 0; i < K; ++i) to_light.distance[i] = std::sqrt(to_light.distance[i]);
  const Floats<K> along = -(x * axis.x + y * axis.y + z * axis.z);
  to_light.in_range = to_light.distance < light.range;
  to_light.in_cone = along > light.cos_outer * to_light.distance;
  set_facing(s, first, to_light);
  Floats<K> reach;
  load(reach, s.reach + first);
  to_light.covered = reach > 0;
}

/// Makes shadow rays. A ray starts at the offset surface point. It ends before the light, by an offset that
/// also counts the light's own coordinates; to a directional light it has no end.
template <int K>
void aim(const TileSurface& s, int first, const ShadowLight& light, const LightGeometry<K>& to_light,
         RayPacket<K>& ray) {
  std::memcpy(ray.org_x, s.ox + first, sizeof ray.org_x);
  std::memcpy(ray.org_y, s.oy + first, sizeof ray.org_y);
  std::memcpy(ray.org_z, s.oz + first, sizeof ray.org_z);
  store(Floats<K>{}, ray.tnear);
  if (light.kind == LightKind::Directional) {
    store(to_light.x, ray.dir_x), store(to_light.y, ray.dir_y), store(to_light.z, ray.dir_z);
    store(kFar - Floats<K>{}, ray.tfar);
    return;
  }
  Floats<K> x, y, z, left_out;
  load(x, s.ox + first), load(y, s.oy + first), load(z, s.oz + first), load(left_out, s.reach + first);
  x = light.position.v.x - x, y = light.position.v.y - y, z = light.position.v.z - z;
  store(x, ray.dir_x), store(y, ray.dir_y), store(z, ray.dir_z);
  left_out = kOffset * (left_out + light.reach) / to_light.distance;
  const Floats<K> end = 1.0f - left_out;
  store(end > 0 ? end : Floats<K>{}, ray.tfar);
}

/// Sets `bit` in the words of those `lanes` that are -1.
template <int K>
void set_bit(const Ints<K>& lanes, std::uint32_t bit, std::uint32_t* words) {
  Ints<K> word;
  load(word, words);
  word |= lanes & static_cast<std::int32_t>(bit);
  store(word, words);
}

/// Gathers single shadow rays of one light into full packets.
template <int K>
struct GatheredRays {
  RayPacket<K> ray;
  int pixel[K];  ///< whose rays they are
  int count = 0;

  /// Appends lane `i` of the packet that begins at pixel `first`.
  void add(const RayPacket<K>& from, int first, int i) {
    ray.org_x[count] = from.org_x[i], ray.org_y[count] = from.org_y[i], ray.org_z[count] = from.org_z[i];
    ray.dir_x[count] = from.dir_x[i], ray.dir_y[count] = from.dir_y[i], ray.dir_z[count] = from.dir_z[i];
    ray.tfar[count] = from.tfar[i];
    pixel[count++] = first + i;
  }
};

/// Traces the gathered rays, and sets `bit` in the words of their pixels that the light reaches.
template <int K, class Occluded>
void trace_gathered(GatheredRays<K>& rays, std::uint32_t bit, std::uint32_t (&words)[kTilePixels],
                    Occluded&& occluded) {
  Lanes<K> lanes;
  for (int i = 0; i < K; ++i) lanes.valid[i] = i < rays.count ? -1 : 0;
  store(Floats<K>{}, rays.ray.tnear);
  occluded(lanes, rays.ray);
  for (int i = 0; i < rays.count; ++i) words[rays.pixel[i]] |= rays.ray.tfar[i] >= 0 ? bit : 0u;
  rays.count = 0;
}

/// Whether the packet that begins at pixel `first` lies in one of `blocks`.
inline bool is_in(BlockBits blocks, int first) {
  return (blocks >> (first / kBlockPixels) & 1) != 0;
}

/// The covered pixels in `blocks` of the group.
inline std::uint32_t covered_in(BlockBits blocks, const TileSurface& surface) {
  if (blocks == kAllBlocks) return surface.covered;
  std::uint32_t covered = 0;
  for (int i = 0; i < surface.pixels; ++i) covered += is_in(blocks, i) && surface.reach[i] > 0 ? 1u : 0u;
  return covered;
}

/// Sets `bit` in the words of those pixels of `blocks` that `light` reaches. Traces only rays of pixels that
/// face the light, in its range and cone. `occluded(lanes, packet)` traces.
///
/// A packet whose lanes all need a ray is traced as it is. The rays of the other packets are gathered. This
/// makes 5 % fewer packets for whole views of the living room, and 12 % fewer for edge blocks of room.glb.
/// The core time of the latter falls by 1 to 2 %, and that of whole views does not change. If full packets
/// were gathered too, the shadow stage would take 8 % longer.
template <int K, class Surface, class Occluded>
GroupRays shadow_group(const Surface& surface, BlockBits blocks, const ShadowLight& light, std::uint32_t bit,
                       std::uint32_t (&words)[kTilePixels], Occluded&& occluded) {
  RayPacket<K> ray;
  GatheredRays<K> gathered;
  set_constants(ray);
  set_constants(gathered.ray);
  Ints<K> traced{}, too_far{}, beside{}, away{};
  for (int first = 0; first < surface.pixels; first += K) {
    if (!is_in(blocks, first)) continue;
    LightGeometry<K> to_light;
    face_light(surface, first, light, to_light);
    const Ints<K> near = to_light.covered & to_light.in_range, lit = near & to_light.in_cone;
    too_far += to_light.covered & ~to_light.in_range;
    beside += near & ~to_light.in_cone;
    away += lit & ~to_light.faces;
    const Ints<K> needed = lit & to_light.faces;
    if (first_of(needed) < 0) continue;
    traced += needed;
    aim(surface, first, light, to_light, ray);
    Lanes<K> lanes;
    store(needed, lanes.valid);
    if (first_of(~needed) >= 0) {
      for (int i = 0; i < K; ++i) {
        if (lanes.valid[i] == 0) continue;
        gathered.add(ray, first, i);
        if (gathered.count == K) trace_gathered<K>(gathered, bit, words, occluded);
      }
      continue;
    }
    occluded(lanes, ray);
    Floats<K> met;
    load(met, ray.tfar);
    set_bit<K>(needed & (met >= 0), bit, words + first);
  }
  if (gathered.count > 0) trace_gathered<K>(gathered, bit, words, occluded);
  return {counted(traced), counted(too_far), counted(beside), counted(away)};
}

/// The same as shadow_group, but traces a ray for every covered pixel of `blocks`.
template <int K, class Occluded>
GroupRays shadow_whole_group(const TileSurface& surface, BlockBits blocks, const ShadowLight& light,
                             std::uint32_t bit, std::uint32_t (&words)[kTilePixels], Occluded&& occluded) {
  RayPacket<K> ray;
  set_constants(ray);
  for (int first = 0; first < surface.pixels; first += K) {
    if (!is_in(blocks, first)) continue;
    LightGeometry<K> to_light;
    face_light(surface, first, light, to_light);
    aim(surface, first, light, to_light, ray);
    Lanes<K> lanes;
    store(to_light.covered, lanes.valid);
    occluded(lanes, ray);
    Floats<K> met;
    load(met, ray.tfar);
    set_bit<K>(to_light.covered & to_light.faces & to_light.in_range & to_light.in_cone & (met >= 0), bit,
               words + first);
  }
  return {.traced = covered_in(blocks, surface)};
}

}  // namespace farshade
