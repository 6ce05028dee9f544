#include "stereo/scene/sky.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "stereo/scene/scene_state.h"

namespace farshade {
namespace {

constexpr double kLeastPart = 0.04, kLeastSky = 0.45;  ///< of all directions
/// A dome may end a little above the ground: by this share of its size.
constexpr double kOpen = 0.01;

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
  const double open = kOpen * glm::length(outer.high - outer.low);
  return glm::all(glm::lessThanEqual(outer.low, inner.low + open)) &&
         glm::all(glm::greaterThanEqual(outer.high, inner.high - open));
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

/// The instances of the sky, with `also_unlit` taken for an unlit material.
std::vector<std::size_t> sky_of(const Scene& scene, std::optional<std::uint32_t> also_unlit) {
  const SceneState state = state_at(scene, Time{});
  Bounds lit = kNoPoint;
  std::vector<std::size_t> unlit;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const std::uint32_t material = scene.meshes[instance.mesh].material;
    if ((scene.materials[material].unlit || material == also_unlit) && !instance.rig)
      unlit.push_back(i);
    else
      lit = joined(lit, box_of(scene, state, i));
  }
  if (unlit.empty() || unlit.size() == scene.instances.size()) return {};
  const glm::dvec3 middle = (lit.low + lit.high) * 0.5;
  std::vector<std::size_t> sky;
  Bounds around = kNoPoint;
  double filled = 0;
  for (const std::size_t i : unlit) {
    const double part =
        part_of_sphere(scene.meshes[scene.instances[i].mesh], state.stage_from_object[i], middle);
    if (part < kLeastPart) continue;
    sky.push_back(i);
    around = joined(around, box_of(scene, state, i));
    filled += part;
  }
  if (filled < kLeastSky || !contains(around, lit)) return {};
  return sky;
}

}  // namespace

bool would_be_sky(const Scene& scene, std::uint32_t instance) {
  const auto sky = sky_of(scene, scene.meshes[scene.instances[instance].mesh].material);
  return std::ranges::find(sky, instance) != sky.end();
}

void find_sky(Scene& scene) {
  const std::vector<std::size_t> sky = sky_of(scene, std::nullopt);
  if (sky.empty()) return;
  for (const std::size_t i : sky) scene.instances[i].casts = false;
  scene.warnings.push_back("'" + scene.nodes[scene.instances[sky.front()].node].name +
                           "' is unlit and closed around everything: it casts no shadow");
}

}  // namespace farshade
