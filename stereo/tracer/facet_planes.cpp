#include "stereo/tracer/facet_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "stereo/tracer/ray_packet.h"

namespace farshade {
namespace {

constexpr double kUlp = 1.0 / (1 << 24);  // u in tile_stages.h

using Corners = std::array<glm::dvec3, 3>;

/// The offset in tile_stages.h is 64 u M. Rounding takes up to 10 u M before a ray starts, and up to 24 u M
/// in the intersection with a plane, for triangles less than kShape times as long as high. Each further
/// multiple adds 2 u M in the products of the traversal's normal. So kDoubt = 32 leaves 8 u M for the plane's
/// own arithmetic (light_proof.h) and 22 u M for the thickness of the slab. Triangles thinner than 1 /
/// kThinnest get no plane. This only saves planes, which would prove hardly anything with such a doubt: any
/// value from 1e2 to 1e6 would do.
constexpr double kDoubt = 32, kShape = 8, kDoubtPerShape = 2, kThinnest = 1e4;
/// Largest thickness of a slab of several triangles, in u M. The slab of a single triangle is at most 4 u M
/// thick. A lower limit joins fewer triangles. Up to 22 u M, rays from the slab's lower side still start
/// beyond its doubt.
constexpr double kJoined = 12;
/// Errors are proportional to the largest coordinate M, so triangles share a plane only if their M is within
/// this factor. A smaller factor only shares fewer planes.
constexpr double kSameReach = 1.25;
/// How many of the newest planes a triangle is compared with.
constexpr std::size_t kRecent = 8;

/// Height over longest edge.
double height_share(const Corners& p) {
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, glm::length(p[i] - p[(i + 1) % 3]));
  return longest > 0 ? glm::length(glm::cross(p[1] - p[0], p[2] - p[0])) / (longest * longest) : 0;
}

float rounded_down(double x) {
  return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity());
}
float rounded_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

/// The slab that also contains the triangle `p`.
FacetPlane widened(FacetPlane plane, const Corners& p) {
  for (const glm::dvec3& corner : p) {
    const double along = glm::dot(glm::dvec3(plane.normal), corner);
    plane.low = std::min(plane.low, rounded_down(along));
    plane.high = std::max(plane.high, rounded_up(along));
  }
  return plane;
}

bool is_well_shaped(const FacetPlane& plane) {
  return plane.doubt <= static_cast<float>(1.0001 * kDoubt * kUlp * plane.reach);
}

bool may_join(const FacetPlane& plane, const FacetPlane& alone) {
  const double ratio = alone.reach / plane.reach;
  return std::abs(glm::dot(plane.normal, alone.normal)) > 0.999f && ratio < kSameReach &&
         ratio > 1 / kSameReach && is_well_shaped(plane) && is_well_shaped(alone);
}

}  // namespace

FacetPlanes planes_of(const SurfaceModel& model) {
  FacetPlanes result;
  std::array<std::uint32_t, kRecent> recent{};
  std::size_t made = 0;
  for (const Patch& patch : model.patches().first(model.fixed_count()))
    for (std::uint32_t t = patch.first_triangle; t < patch.first_triangle + patch.triangle_count; ++t) {
      const Facet& facet = model.facets()[t];
      const glm::uvec3& v = model.triangles()[t];
      const auto positions = model.positions();
      const Corners p{glm::dvec3(positions[v.x]), glm::dvec3(positions[v.y]), glm::dvec3(positions[v.z])};
      result.reach = std::max(result.reach, facet.reach);
      const double height = height_share(p);
      if (height * kThinnest < 1 || facet.normal == glm::vec3(0.0f)) {
        result.of_triangle.push_back(kNoPlane);
        continue;
      }
      const double doubt = kDoubt + kDoubtPerShape * std::max(1 / height - kShape, 0.0);
      FacetPlane alone{facet.normal, kFar, -kFar, facet.reach, rounded_up(doubt * kUlp * facet.reach)};
      alone = widened(alone, p);
      std::uint32_t id = kNoPlane;
      for (std::size_t i = 0; i < std::min(made, kRecent) && id == kNoPlane; ++i) {
        FacetPlane& plane = result.planes[recent[i]];
        if (!may_join(plane, alone)) continue;
        const FacetPlane with = widened(plane, p);
        if (with.high - with.low > kJoined * kUlp * plane.reach) continue;
        id = recent[i];
        plane = with;
        plane.reach = std::max(plane.reach, alone.reach);
        plane.doubt = std::max(plane.doubt, alone.doubt);
      }
      if (id == kNoPlane) {
        id = static_cast<std::uint32_t>(result.planes.size());
        result.planes.push_back(alone);
        recent[made++ % kRecent] = id;
      }
      result.of_triangle.push_back(id);
    }
  return result;
}

}  // namespace farshade
