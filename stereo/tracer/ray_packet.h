/// Packets of K rays side by side, field by field, in the memory order of Embree's packets (ray_scene.cpp
/// asserts it), so that what the stages write is what the traversal reads.
#pragma once

#include <cstdint>
#include <limits>

namespace farshade {

inline constexpr std::uint32_t kNothing = ~0u;  ///< geometry or instance number where no surface was met
inline constexpr float kFar = std::numeric_limits<float>::infinity();

template <int K>
struct alignas(4 * K) RayPacket {
  float org_x[K], org_y[K], org_z[K], tnear[K];
  float dir_x[K], dir_y[K], dir_z[K], time[K];
  float tfar[K];  ///< in: where the ray ends; out: distance met (intersect), or -infinity where something was
                  ///< met
  std::uint32_t mask[K], id[K], flags[K];
};

/// What the rays met. Barycentric (u, v) weigh the triangle's second and third vertex.
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

/// -1 = trace this lane, 0 = leave it alone.
template <int K>
struct alignas(4 * K) Lanes {
  std::int32_t valid[K];
};

/// The fields that are the same for every ray.
template <int K>
void set_constants(RayPacket<K>& ray) {
  for (int i = 0; i < K; ++i) {
    ray.time[i] = 0;
    ray.mask[i] = ~0u;
    ray.id[i] = ray.flags[i] = 0;
  }
}

}  // namespace farshade
