/// Packets of K rays as structures of arrays, in the memory layout of Embree's packets (ray_scene.cpp asserts
/// it). So the traversal reads what the tile stages write, without a copy. Origins and directions are in
/// anchor space.
#pragma once

#include <cstdint>
#include <limits>

namespace farshade {

inline constexpr std::uint32_t kNothing = ~0u;  ///< geometry or instance number of a ray that hit nothing
inline constexpr float kFar = std::numeric_limits<float>::infinity();

template <int K>
struct alignas(4 * K) RayPacket {
  float org_x[K], org_y[K], org_z[K], tnear[K];
  float dir_x[K], dir_y[K], dir_z[K], time[K];
  /// In: where the ray ends. Out: the hit's distance (intersect), or -infinity after a hit (occluded).
  float tfar[K];
  std::uint32_t mask[K], id[K], flags[K];
};

/// What the rays hit. The barycentric (u, v) weigh the triangle's second and third vertex.
template <int K>
struct alignas(4 * K) HitPacket {
  float ng_x[K], ng_y[K], ng_z[K];
  float u[K], v[K];
  std::uint32_t primitive[K], geometry[K], instance[K], instance_primitive[K];
};

template <int K>
struct RayHitPacket {
  RayPacket<K> ray;
  HitPacket<K> hit;
};

/// -1 = trace this lane, 0 = skip it.
template <int K>
struct alignas(4 * K) Lanes {
  std::int32_t valid[K];
};

/// Sets the fields that are the same for every ray.
template <int K>
void set_constants(RayPacket<K>& ray) {
  for (int i = 0; i < K; ++i) {
    ray.time[i] = 0;
    ray.mask[i] = ~0u;
    ray.id[i] = ray.flags[i] = 0;
  }
}

}  // namespace farshade
