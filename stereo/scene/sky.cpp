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
/// By which part of its half size the sky may end above the ground, or the ground may reach out of it, if it
/// is seen from the middle. An unlit house on its ground is seen from outside.
constexpr double kOpen = 0.5;
constexpr double kLeastOpen = 0.03;  ///< for a sky whose triangles are the wrong way round
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

/// The part of all directions that the mesh fills as seen from `middle`: negative if its backs are seen. A
/// triangle in front of another one counts for both.
double part_of_sphere(const Mesh& mesh, const Affine<Stage, Object>& stage_from_object,
                      const glm::dvec3& middle) {
  const auto corner = [&](std::uint32_t v) {
    return stage_from_object(Point<Object>{glm::dvec3(mesh.positions[v])}).v - middle;
  };
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) sum += part_of_sphere(corner(t.x), corner(t.y), corner(t.z));
  return glm::determinant(glm::dmat3(stage_from_object.matrix)) < 0 ? sum : -sum;
}

/// `part`: how far `inner` may reach out of `outer`, as a part of its half size.
bool contains(const Bounds& outer, const Bounds& inner, double part) {
  const glm::dvec3 open = part * 0.5 * (outer.high - outer.low);
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

using Places = std::vector<Affine<Stage, Object>>;

Bounds box_of(const Scene& scene, const Places& places, std::size_t instance) {
  return moved(places[instance].matrix, bounds_of(scene.meshes[scene.instances[instance].mesh].positions));
}

}  // namespace

Bounds bounds_without_sky(const Scene& scene) {
  if (std::ranges::all_of(scene.instances, &Instance::casts)) return scene.bounds;
  const Places places = places_at_start(scene);
  Bounds bounds = kNoPoint;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    if (scene.instances[i].casts) bounds = joined(bounds, box_of(scene, places, i));
  return bounds;
}

namespace {

/// The instances of the sky, which have materials that may be a sky.
std::vector<std::uint32_t> sky_of(const Scene& scene, const std::function<bool(std::uint32_t)>& may_be_sky) {
  const Places places = places_at_start(scene);
  Bounds lit = kNoPoint;
  std::vector<std::uint32_t> unlit;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (may_be_sky(scene.meshes[instance.mesh].material) && !instance.rig)
      unlit.push_back(i);
    else
      lit = joined(lit, box_of(scene, places, i));
  }
  if (unlit.empty() || unlit.size() == scene.instances.size()) return {};
  const glm::dvec3 middle = (lit.low + lit.high) * 0.5;
  std::vector<std::pair<double, double>> reach;
  for (const std::uint32_t i : unlit)
    reach.push_back(distances(scene.meshes[scene.instances[i].mesh], places[i], middle));
  const double far = std::max(glm::length(lit.high - middle),
                              kFar * std::ranges::max(reach, {}, &std::pair<double, double>::second).second);
  std::vector<std::uint32_t> sky;
  Bounds around = kNoPoint;
  double filled = 0;
  bool is_seen = true;
  for (std::size_t n = 0; n < unlit.size(); ++n) {
    const std::uint32_t i = unlit[n];
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    const double fronts = part_of_sphere(mesh, places[i], middle), part = std::abs(fronts);
    if (part < kLeastPart && reach[n].first < far) continue;
    is_seen &= part < kLeastPart || fronts > 0 || scene.materials[mesh.material].double_sided;
    sky.push_back(i);
    around = joined(around, box_of(scene, places, i));
    filled += part;
  }
  if (filled < kLeastSky || !contains(around, lit, is_seen ? kOpen : kLeastOpen)) return {};
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
    const Material& material = scene.materials[m];
    return is_unlit(m) || (material.glows && glm::vec3(material.base_color) == glm::vec3(0.0f));
  };
  std::vector<std::uint32_t> sky = sky_of(scene, is_unlit);
  if (sky.empty()) sky = sky_of(scene, is_dark);
  if (sky.empty()) return;
  for (const std::uint32_t i : sky) scene.instances[i].casts = false;
  const Instance& first = scene.instances[sky.front()];
  scene.warnings.push_back(fmt::format("'{}' is {} and closed around everything: it casts no shadow",
                                       printable(scene.nodes[first.node].name),
                                       is_unlit(scene.meshes[first.mesh].material) ? "unlit" : "black"));
}

}  // namespace farshade
