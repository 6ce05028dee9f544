/// The two stages of a 16x16 tile, on buffers that stay in the first-level cache between them.
///
/// see_tile finds the nearest surface of each pixel; shadow_tile asks for one light which of those surfaces
/// it reaches.
///
/// A shadow ray's offset is counted in units in the last place, after C. Waechter and N. Binder, "A fast and
/// robust method for avoiding self-intersection", Ray Tracing Gems I, chapter 6, but of the largest
/// coordinate M that takes part, and its count is derived. With u = 2^-24, distances to the surface's plane
/// are wrong by at most:
///   barycentric sum of the hit point   2uM (weights do not sum to 1) + 3uM a coordinate, times sqrt 3:  8.7
///   uM adding the offset                                                     1 uM a
///   coordinate:            1.7 uM Embree: vertices minus origin, |v - o| <= 2M a coordinate, rounded: 3.5 uM
///   Embree: dot of that with the normal, 3 roundings of 2 sqrt 3 M:                                    10.4
///   uM Embree: its normal, from edges of such vertices (4uM) and a cross product, well-shaped triangle:   10
///   uM
/// Together 35 uM; 64 uM leaves room for triangles whose height is a few times smaller than their longest
/// edge. So a thing closer than 2^-18 of the largest coordinate to a surface may fail to cast on it.
///
/// Rays start at the surface. Packets that share their origin at the light were 0 to 3 % faster in three
/// scenes, but then the light's coordinates would count into M.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "stereo/frame/view.h"
#include "stereo/tracer/ray_scene.h"
#include "stereo/tracer/tile_lights.h"

namespace farshade {

/// Primary rays of a view: origin, and direction = corner + x across + y down for pixel position (x, y).
struct ViewRays {
  glm::vec3 origin;
  glm::dvec3 corner, across, down;
};

inline ViewRays rays_of(const View& view, const glm::dvec3& anchor) {
  const EyeWindow window = window_of(view.fov);
  const auto stage_ray = [&](double x, double y) {
    return view.stage_from_eye(Vector<Eye>{pixel_ray(window, view.size, {x, y})}).v;
  };
  const glm::dvec3 corner = stage_ray(0, 0);
  return {glm::vec3(view.stage_from_eye.translation - anchor), corner, stage_ray(1, 0) - corner,
          stage_ray(0, 1) - corner};
}

/// One lane's hit, carried into `out` at `at`.
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
    p = placement.linear * p + placement.translation;
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

inline void resolve_miss(TileSurface& out, int at) {
  out.px[at] = out.py[at] = out.pz[at] = out.reach[at] = 0;
  out.ox[at] = out.oy[at] = out.oz[at] = 0;
  out.nx[at] = out.ny[at] = out.nz[at] = 0;
  out.gx[at] = out.gy[at] = out.gz[at] = 0;
}

/// Primary rays through the pixel centres of `rect`.
template <int K>
void see_tile(const RayScene& scene, const SurfaceModel& model, const ViewRays& view, const TileRect& rect,
              TileSurface& out) {
  const glm::vec3 corner(view.corner + view.across * (rect.x0 + 0.5) + view.down * (rect.y0 + 0.5));
  const glm::vec3 across(view.across), down(view.down);
  const std::uint32_t width = rect.x1 - rect.x0, height = rect.y1 - rect.y0;
  RayHitPacket<K> packet;
  set_constants(packet.ray);
  out.covered = 0;
  for (int first = 0; first < kTilePixels; first += K) {
    Lanes<K> lanes;
    RayPacket<K>& ray = packet.ray;
    for (int i = 0; i < K; ++i) {
      const TilePixel pixel = kTileOrder[static_cast<std::size_t>(first + i)];
      const float x = pixel.x, y = pixel.y;
      lanes.valid[i] = ((pixel.x < width) & (pixel.y < height)) ? -1 : 0;
      ray.org_x[i] = view.origin.x, ray.org_y[i] = view.origin.y, ray.org_z[i] = view.origin.z;
      ray.dir_x[i] = corner.x + across.x * x + down.x * y;
      ray.dir_y[i] = corner.y + across.y * x + down.y * y;
      ray.dir_z[i] = corner.z + across.z * x + down.z * y;
      ray.tnear[i] = 0;
      ray.tfar[i] = kFar;
    }
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

/// What becomes of the covered pixels of a tile under one light.
struct TileRays {
  std::uint64_t traced = 0;
  std::uint64_t proven = 0;                                   ///< lit without a ray
  std::uint64_t out_of_range = 0, out_of_cone = 0, away = 0;  ///< dark without a ray, by the first of these

  TileRays& operator+=(const TileRays& b) {
    traced += b.traced, proven += b.proven;
    out_of_range += b.out_of_range, out_of_cone += b.out_of_cone, away += b.away;
    return *this;
  }
};

/// One packet's way to the light.
template <int K>
struct LightWay {
  alignas(4 * K) float distance[K];
  Lanes<K> faces;  ///< both normals face the light
  Lanes<K> in_range, in_cone;
};

/// Vector from each surface to the light, and what of the definition of a bit holds before any ray.
template <int K>
void face_light(const TileSurface& s, int first, const ShadowLight& light, RayPacket<K>& to_light,
                LightWay<K>& way) {
  const bool directional = light.kind == LightKind::Directional;
  for (int i = 0; i < K; ++i) {
    const int at = first + i;
    const float x = directional ? -light.direction.x : light.position.x - s.px[at];
    const float y = directional ? -light.direction.y : light.position.y - s.py[at];
    const float z = directional ? -light.direction.z : light.position.z - s.pz[at];
    const float d = std::sqrt(x * x + y * y + z * z);
    const float along = -(x * light.direction.x + y * light.direction.y + z * light.direction.z);
    const bool faces =
        (s.nx[at] * x + s.ny[at] * y + s.nz[at] * z > 0) & (s.gx[at] * x + s.gy[at] * y + s.gz[at] * z > 0);
    way.faces.valid[i] = -static_cast<std::int32_t>(faces);
    way.in_range.valid[i] = -static_cast<std::int32_t>(d < light.range);
    way.in_cone.valid[i] = -static_cast<std::int32_t>(along > light.cos_outer * d);
    to_light.dir_x[i] = x, to_light.dir_y[i] = y, to_light.dir_z[i] = z;
    way.distance[i] = d;
  }
}

/// Turns vectors to the light into rays: from the offset surface point to the light, as far as the same
/// offset before it, or without end.
template <int K>
void aim(const TileSurface& s, int first, const ShadowLight& light, const float (&distance)[K],
         RayPacket<K>& ray) {
  const bool directional = light.kind == LightKind::Directional;
  for (int i = 0; i < K; ++i) {
    const int at = first + i;
    const float left_out = kOffset * (s.reach[at] + light.reach) / distance[i];
    ray.org_x[i] = s.ox[at], ray.org_y[i] = s.oy[at], ray.org_z[i] = s.oz[at];
    if (!directional) {
      ray.dir_x[i] = light.position.x - ray.org_x[i];
      ray.dir_y[i] = light.position.y - ray.org_y[i];
      ray.dir_z[i] = light.position.z - ray.org_z[i];
    }
    ray.tnear[i] = 0;
    ray.tfar[i] = directional ? kFar : std::max(1.0f - left_out, 0.0f);
  }
}

template <int K>
std::uint64_t count_of(const Lanes<K>& lanes) {
  std::int32_t count = 0;
  for (int i = 0; i < K; ++i) count -= lanes.valid[i];
  return static_cast<std::uint64_t>(count);
}

/// Counts the covered lanes to which the light does not matter.
template <int K>
void count_dark(const TileSurface& s, int first, const LightWay<K>& way, TileRays& rays) {
  for (int i = 0; i < K; ++i) {
    if (!(s.reach[first + i] > 0)) continue;
    if (way.in_range.valid[i] == 0)
      ++rays.out_of_range;
    else if (way.in_cone.valid[i] == 0)
      ++rays.out_of_cone;
    else if (way.faces.valid[i] == 0)
      ++rays.away;
  }
}

/// Sets `bit` in the words of the pixels that `light` reaches, tracing only rays whose answer is not known
/// before. `map` is the light's, or null. `occluded(lanes, packet)` traces.
template <int K, class Occluded>
TileRays shadow_tile(const TileSurface& surface, const ShadowLight& light, const LightMap* map,
                     std::uint32_t bit, std::uint32_t (&words)[kTilePixels], Occluded&& occluded) {
  RayPacket<K> ray;
  set_constants(ray);
  TileRays rays;
  for (int first = 0; first < kTilePixels; first += K) {
    LightWay<K> way;
    face_light(surface, first, light, ray, way);
    Lanes<K> needed, proven;
    std::int32_t covered = 0;
    for (int i = 0; i < K; ++i) {
      covered += surface.reach[first + i] > 0 ? 1 : 0;
      needed.valid[i] = way.faces.valid[i] & way.in_range.valid[i] & way.in_cone.valid[i];
    }
    const std::uint64_t mattering = count_of(needed);
    if (mattering < static_cast<std::uint64_t>(covered)) count_dark(surface, first, way, rays);
    if (mattering == 0) continue;
    std::uint64_t known = 0;
    if (map != nullptr) {
      prove(*map, surface, first, needed, proven);
      known = count_of(proven);
      rays.proven += known;
      for (int i = 0; i < K; ++i) words[first + i] |= proven.valid[i] != 0 ? bit : 0u;
      if (known == mattering) continue;
      for (int i = 0; i < K; ++i) needed.valid[i] &= ~proven.valid[i];
    }
    rays.traced += mattering - known;
    aim(surface, first, light, way.distance, ray);
    occluded(needed, ray);
    for (int i = 0; i < K; ++i) words[first + i] |= ((needed.valid[i] != 0) & (ray.tfar[i] >= 0)) ? bit : 0u;
  }
  return rays;
}

/// As shadow_tile, and leaving nothing out: a ray for each covered pixel.
template <int K, class Occluded>
TileRays shadow_whole_tile(const TileSurface& surface, const ShadowLight& light, std::uint32_t bit,
                           std::uint32_t (&words)[kTilePixels], Occluded&& occluded) {
  RayPacket<K> ray;
  set_constants(ray);
  TileRays rays;
  for (int first = 0; first < kTilePixels; first += K) {
    LightWay<K> way;
    face_light(surface, first, light, ray, way);
    aim(surface, first, light, way.distance, ray);
    Lanes<K> covered;
    for (int i = 0; i < K; ++i) covered.valid[i] = surface.reach[first + i] > 0 ? -1 : 0;
    rays.traced += count_of(covered);
    occluded(covered, ray);
    for (int i = 0; i < K; ++i) {
      const std::int32_t matters = way.faces.valid[i] & way.in_range.valid[i] & way.in_cone.valid[i];
      words[first + i] |= ((matters != 0) & (ray.tfar[i] >= 0)) ? bit : 0u;
    }
  }
  return rays;
}

}  // namespace farshade
