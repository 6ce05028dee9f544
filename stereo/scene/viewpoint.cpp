#include "stereo/scene/viewpoint.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <numbers>
#include <set>

#include "stereo/scene/scene_state.h"
#include "stereo/scene/sky.h"

namespace farshade {
namespace {

constexpr double kEyeHeight_m = 1.6, kLeastRoom_m = 2, kClearance_m = 0.3;
constexpr std::size_t kAround = 12, kSeen = 10;  ///< of the directions
constexpr std::size_t kInstances = 3;
constexpr std::size_t kMostLamps = 4;
/// The search tests every triangle, so it is left out for larger scenes.
constexpr std::uint64_t kMostTriangles = 4'000'000;
/// The distance from the middle of a scene that is seen from outside, and how far above it, in radii.
constexpr double kDistance = 1.3, kAbove = 0.25;
/// Nearer things cannot be looked at for long. Things that look smaller there are seen from nearer, but not
/// from where they are outside of one eye's picture.
constexpr double kNearest_m = 0.25, kNearestOfAll_m = 0.16, kSmall_rad = 1.2 * std::numbers::pi / 180;
/// A side that shows less than this part of what another one shows is left.
constexpr double kLeastShown = 0.2;

/// Level directions come first.
using Directions = std::array<glm::dvec3, 14>;
constexpr std::size_t kLevel = 4;

Directions directions() {
  Directions all{glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1),
                 glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, -1, 0)};
  for (int i = 0; i < 8; ++i)
    all[static_cast<std::size_t>(6 + i)] =
        glm::normalize(glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  return all;
}

struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  bool faces = false;  ///< its counter-clockwise side is seen
  std::uint32_t instance = 0;
};

/// T. Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
void meet(const glm::dvec3& eye, const glm::dvec3& ray, const std::array<glm::dvec3, 3>& corners,
          std::uint32_t instance, Hit& hit) {
  const auto& [a, b, c] = corners;
  const glm::dvec3 e1 = b - a, e2 = c - a, p = glm::cross(ray, e2);
  const double determinant = glm::dot(e1, p);
  if (determinant == 0) return;
  const glm::dvec3 s = eye - a, q = glm::cross(s, e1);
  const double u = glm::dot(s, p) / determinant, v = glm::dot(ray, q) / determinant;
  const double distance = glm::dot(e2, q) / determinant;
  if (u < 0 || v < 0 || u + v > 1 || distance <= 0 || distance >= hit.distance) return;
  hit = {distance, determinant > 0, instance};
}

using Hits = std::array<Hit, Directions{}.size()>;

/// What is seen from a place.
struct Sight {
  Hits around{};
  std::array<Hit, kMostLamps> to_lamps{};
  bool sees_lamp = false;
};

/// The first lamps that shine inside of the bounds.
std::vector<glm::dvec3> lamps_in(const Bounds& bounds, const SceneState& state) {
  std::vector<glm::dvec3> lamps;
  for (const Light& light : state.light_set.lights)
    if (light.kind != LightKind::Directional && lamps.size() < kMostLamps &&
        glm::clamp(light.position.v, bounds.low, bounds.high) == light.position.v)
      lamps.push_back(light.position.v);
  return lamps;
}

/// What is seen from each of `eyes`. Every triangle is tested: this is done once.
template <std::size_t N>
std::array<Sight, N> look_around(const Scene& scene, const Bounds& bounds,
                                 const std::array<glm::dvec3, N>& eyes) {
  const Directions rays = directions();
  std::array<Sight, N> sights{};
  const SceneState state = state_at(scene, Time{});
  const std::vector<glm::dvec3> lamps = lamps_in(bounds, state);
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    if (!scene.instances[i].casts) continue;  // a sky is no wall
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    const Affine<Stage, Object>& pose = state.stage_from_object[i];
    const bool mirrored = glm::determinant(glm::dmat3(pose.matrix)) < 0;
    const auto corner = [&](std::uint32_t v) { return pose(Point<Object>{glm::dvec3(mesh.positions[v])}).v; };
    for (const glm::uvec3& t : mesh.triangles) {
      const std::array corners{corner(t.x), corner(mirrored ? t.z : t.y), corner(mirrored ? t.y : t.z)};
      for (std::size_t eye = 0; eye < N; ++eye) {
        for (std::size_t ray = 0; ray < rays.size(); ++ray)
          meet(eyes[eye], rays[ray], corners, i, sights[eye].around[ray]);
        for (std::size_t lamp = 0; lamp < lamps.size(); ++lamp)
          meet(eyes[eye], lamps[lamp] - eyes[eye], corners, i, sights[eye].to_lamps[lamp]);
      }
    }
  }
  for (Sight& sight : sights)  // distances to lamps are parts of the way
    sight.sees_lamp = std::any_of(sight.to_lamps.begin(), sight.to_lamps.begin() + std::ssize(lamps),
                                  [](const Hit& hit) { return hit.distance >= 1; });
  return sights;
}

double clearance(const Hits& hits) {
  return std::ranges::min_element(hits, {}, &Hit::distance)->distance;
}

/// A lamp that is seen tells a room from the inside of a solid, whose surface may be double-sided, too.
bool is_in_room(const Scene& scene, const Sight& sight) {
  std::size_t around = 0, seen = 0, facing = 0;
  std::set<std::uint32_t> instances;
  for (const Hit& hit : sight.around) {
    if (hit.distance == Hit{}.distance) continue;
    const Material& material = scene.materials[scene.meshes[scene.instances[hit.instance].mesh].material];
    ++around;
    facing += hit.faces;
    seen += hit.faces || material.double_sided;
    instances.insert(hit.instance);
  }
  return around >= kAround && seen >= kSeen &&
         (facing >= kSeen || instances.size() >= kInstances || sight.sees_lamp) &&
         clearance(sight.around) >= kClearance_m;
}

/// A lit room is better than a dark one.
double worth(const Sight& sight) {
  return clearance(sight.around) * (sight.sees_lamp ? 2 : 1);
}

/// Looks to the middle of the scene; from there, to the farthest wall.
Rigid<Stage, Eye> inside(const Bounds& bounds, const glm::dvec3& eye, const Hits& hits) {
  const auto reach = [](const Hit& hit) { return hit.distance < Hit{}.distance ? hit.distance : 0.0; };
  const auto* const farthest = std::max_element(
      hits.begin(), hits.begin() + kLevel, [&](const Hit& a, const Hit& b) { return reach(a) < reach(b); });
  glm::dvec3 ahead = (bounds.low + bounds.high) * 0.5 - eye;
  ahead.y = 0;
  if (glm::length(ahead) < kClearance_m)
    ahead = directions()[static_cast<std::size_t>(farthest - hits.begin())];
  return {.rotation = glm::quatLookAt(glm::normalize(ahead), glm::dvec3(0, 1, 0)), .translation = eye};
}

std::optional<Rigid<Stage, Eye>> place_in_room(const Scene& scene, const Bounds& bounds) {
  const glm::dvec3 low = bounds.low, size = bounds.high - low;
  if (std::min({size.x, size.y, size.z}) < kLeastRoom_m || scene.triangle_count > kMostTriangles)
    return std::nullopt;
  std::array<glm::dvec3, 9> eyes{};
  std::size_t count = 0;
  for (const double x : {0.5, 0.3, 0.7})
    for (const double z : {0.5, 0.3, 0.7})
      eyes[count++] = low + glm::dvec3(size.x * x, std::min(kEyeHeight_m, size.y * 0.5), size.z * z);
  const std::array<Sight, 9> sights = look_around(scene, bounds, eyes);
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < eyes.size(); ++i)
    if (is_in_room(scene, sights[i]) && (!best || worth(sights[i]) > worth(sights[*best]))) best = i;
  if (!best) return std::nullopt;
  return inside(bounds, eyes[*best], sights[*best].around);
}

}  // namespace

Rigid<Stage, Eye> viewpoint_of(const Scene& scene) {
  return scene.camera ? *scene.camera : chosen_viewpoint(scene);
}

namespace {

/// The area that can be seen from afar in each direction, without regard to what stands before it.
template <std::size_t N>
std::array<double, N> shown_areas(const Scene& scene, const std::array<glm::dvec3, N>& directions) {
  std::array<double, N> areas{};
  const SceneState state = state_at(scene, Time{});
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (!scene.instances[i].casts) continue;
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    const Affine<Stage, Object>& pose = state.stage_from_object[i];
    const double sign = glm::determinant(glm::dmat3(pose.matrix)) < 0 ? -1 : 1;
    const auto corner = [&](std::uint32_t v) { return pose(Point<Object>{glm::dvec3(mesh.positions[v])}).v; };
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 a = corner(t.x), normal = sign * glm::cross(corner(t.y) - a, corner(t.z) - a);
      for (std::size_t d = 0; d < N; ++d) {
        const double facing = glm::dot(normal, directions[d]);
        areas[d] += scene.materials[mesh.material].double_sided ? std::abs(facing) : std::max(facing, 0.0);
      }
    }
  }
  return areas;
}

/// From the scene to a viewer in front of it, who sees it from a little above. That is +z, unless hardly
/// anything is seen from there: a plate from its edge, or the back of a picture.
glm::dvec3 to_viewer(const Scene& scene) {
  constexpr double kUp = kAbove / kDistance, kAside = 0.25;
  const std::array<glm::dvec3, 5> ways{glm::dvec3(kAside, kUp, 1), glm::dvec3(1, kUp, kAside),
                                       glm::dvec3(-kAside, kUp, -1), glm::dvec3(-1, kUp, -kAside),
                                       glm::dvec3(kAside, -0.7, 1)};
  if (scene.triangle_count > kMostTriangles) return ways[0];
  const std::array<double, 5> areas = shown_areas(scene, ways);
  const auto best = std::ranges::max_element(areas);
  return areas[0] >= kLeastShown * *best ? ways[0] : ways[static_cast<std::size_t>(best - areas.begin())];
}

}  // namespace

Rigid<Stage, Eye> chosen_viewpoint(const Scene& scene) {
  const Bounds bounds = bounds_without_sky(scene);
  if (const auto place = place_in_room(scene, bounds)) return *place;
  const glm::dvec3 middle = (bounds.low + bounds.high) * 0.5;
  const double radius = std::max(glm::length(bounds.high - bounds.low) * 0.5, 1e-6);
  const double nearest_m = std::clamp(2 * radius / kSmall_rad, kNearestOfAll_m, kNearest_m);
  const double distance = std::max(kDistance * radius, radius + nearest_m);
  const glm::dvec3 way = to_viewer(scene);
  const glm::dvec3 level = glm::normalize(glm::dvec3(way.x, 0, way.z));
  return {.rotation = glm::quatLookAt(-level, glm::dvec3(0, 1, 0)),
          .translation = middle + distance * (level + glm::dvec3(0, way.y, 0))};
}

}  // namespace farshade
