#include "stereo/scene/sky.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "stereo/base/printable.h"
#include "stereo/scene/scene_state.h"

namespace farshade {
namespace {

constexpr double kLeastPart = 0.04, kLeastSky = 0.45;  ///< of all directions
/// The ground may reach out of a dome, and a dome may end above the ground: by this part of its half size.
constexpr double kOpen = 0.5;
/// Smaller things belong to a sky from this part of its farthest distance on.
constexpr double kFar = 0.4;

/// The signed solid angle of a triangle as seen from the origin, as a part of the sphere (Van Oosterom and
/// Strackee 1983).
double part_of_sphere(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
  const double volume = glm::dot(a, glm::cross(b, c));
  const double below = la * lb * lc + glm::dot(a, b) * lc + glm::dot(a, c) * lb + glm::dot(b, c) * la;
  return 2 * std::atan2(volume, below) / (4 * std::numbers::pi);
}

/// The part of all directions that the mesh fills as seen from `middle`. Sides that face away are negative.
double part_of_sphere(const Mesh& mesh, const Affine<Stage, Object>& stage_from_object,
                      const glm::dvec3& middle) {
  const auto corner = [&](std::uint32_t v) {
    return stage_from_object(Point<Object>{glm::dvec3(mesh.positions[v])}).v - middle;
  };
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) sum += part_of_sphere(corner(t.x), corner(t.y), corner(t.z));
  return std::abs(sum);
}

bool contains(const Bounds& outer, const Bounds& inner) {
  const glm::dvec3 open = kOpen * 0.5 * (outer.high - outer.low);
  return glm::all(glm::lessThanEqual(outer.low, inner.low + open)) &&
         glm::all(glm::greaterThanEqual(outer.high, inner.high - open));
}

/// How far the corners of the mesh are from `middle`: the nearest and the farthest.
std::pair<double, double> distances(const Mesh& mesh, const Affine<Stage, Object>& stage_from_object,
                                    const glm::dvec3& middle) {
  std::pair range{std::numeric_limits<double>::infinity(), 0.0};
  for (const glm::vec3& p : mesh.positions) {
    const double distance = glm::length(stage_from_object(Point<Object>{glm::dvec3(p)}).v - middle);
    range = {std::min(range.first, distance), std::max(range.second, distance)};
  }
  return range;
}

Bounds box_of(const Scene& scene, const SceneState& state, std::size_t instance) {
  return moved(state.stage_from_object[instance].matrix,
               bounds_of(scene.meshes[scene.instances[instance].mesh].positions));
}

}  // namespace

Bounds bounds_without_sky(const Scene& scene) {
  if (std::ranges::all_of(scene.instances, &Instance::casts)) return scene.bounds;
  const SceneState state = state_at(scene, Time{});
  Bounds bounds = kNoPoint;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    if (scene.instances[i].casts) bounds = joined(bounds, box_of(scene, state, i));
  return bounds;
}

namespace {

/// The instances of the sky, which have materials that may be a sky.
std::vector<std::uint32_t> sky_of(const Scene& scene, const std::function<bool(std::uint32_t)>& may_be_sky) {
  const SceneState state = state_at(scene, Time{});
  Bounds lit = kNoPoint;
  std::vector<std::uint32_t> unlit;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (may_be_sky(scene.meshes[instance.mesh].material) && !instance.rig)
      unlit.push_back(i);
    else
      lit = joined(lit, box_of(scene, state, i));
  }
  if (unlit.empty() || unlit.size() == scene.instances.size()) return {};
  const glm::dvec3 middle = (lit.low + lit.high) * 0.5;
  std::vector<std::pair<double, double>> reach;
  for (const std::uint32_t i : unlit)
    reach.push_back(distances(scene.meshes[scene.instances[i].mesh], state.stage_from_object[i], middle));
  const double far = std::max(glm::length(lit.high - middle),
                              kFar * std::ranges::max(reach, {}, &std::pair<double, double>::second).second);
  std::vector<std::uint32_t> sky;
  Bounds around = kNoPoint;
  double filled = 0;
  for (std::size_t n = 0; n < unlit.size(); ++n) {
    const std::uint32_t i = unlit[n];
    const double part =
        part_of_sphere(scene.meshes[scene.instances[i].mesh], state.stage_from_object[i], middle);
    if (part < kLeastPart && reach[n].first < far) continue;
    sky.push_back(i);
    around = joined(around, box_of(scene, state, i));
    filled += part;
  }
  if (filled < kLeastSky || !contains(around, lit)) return {};
  return sky;
}

}  // namespace

std::vector<std::uint32_t> would_be_sky(const Scene& scene, std::uint32_t material) {
  const auto sky = sky_of(scene, [&](std::uint32_t m) { return scene.materials[m].unlit || m == material; });
  const bool has_it = std::ranges::any_of(
      sky, [&](std::uint32_t i) { return scene.meshes[scene.instances[i].mesh].material == material; });
  return has_it ? sky : std::vector<std::uint32_t>();
}

void find_sky(Scene& scene) {
  const auto is_unlit = [&](std::uint32_t m) { return scene.materials[m].unlit; };
  const auto is_dark = [&](std::uint32_t m) {
    return is_unlit(m) || glm::vec3(scene.materials[m].base_color) == glm::vec3(0.0f);
  };
  std::vector<std::uint32_t> sky = sky_of(scene, is_unlit);
  const bool black = sky.empty();
  if (black) sky = sky_of(scene, is_dark);
  if (sky.empty()) return;
  for (const std::uint32_t i : sky) scene.instances[i].casts = false;
  scene.warnings.push_back(fmt::format("'{}' is {} and closed around everything: it casts no shadow",
                                       printable(scene.nodes[scene.instances[sky.front()].node].name),
                                       black ? "black" : "unlit"));
}

}  // namespace farshade
