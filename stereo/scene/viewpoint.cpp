#include "stereo/scene/viewpoint.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "stereo/scene/scene_state.h"

namespace farshade {
namespace {

constexpr double kEyeHeight_m = 1.6;
/// A place is inside of a room if the nearest surface faces it in so many of 14 directions.
constexpr std::size_t kFacing = 10;

/// The six axes and the eight diagonals.
std::array<glm::dvec3, 14> directions() {
  std::array<glm::dvec3, 14> all{};
  for (int i = 0; i < 6; ++i) all[static_cast<std::size_t>(i)][i / 2] = i % 2 == 0 ? 1 : -1;
  for (int i = 0; i < 8; ++i)
    all[static_cast<std::size_t>(6 + i)] =
        glm::normalize(glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  return all;
}

struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  bool faces = false;  ///< its counter-clockwise side is seen
};

/// T. Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
void meet(const glm::dvec3& eye, const glm::dvec3& ray, const glm::dvec3& a, const glm::dvec3& b,
          const glm::dvec3& c, Hit& hit) {
  const glm::dvec3 e1 = b - a, e2 = c - a, p = glm::cross(ray, e2);
  const double determinant = glm::dot(e1, p);
  if (determinant == 0) return;
  const glm::dvec3 s = eye - a, q = glm::cross(s, e1);
  const double u = glm::dot(s, p) / determinant, v = glm::dot(ray, q) / determinant;
  const double distance = glm::dot(e2, q) / determinant;
  if (u < 0 || v < 0 || u + v > 1 || distance <= 0 || distance >= hit.distance) return;
  hit = {distance, determinant > 0};
}

/// In how many directions the nearest surface faces `eye`. Every triangle is tested: this is done once.
std::size_t facing(const Scene& scene, const glm::dvec3& eye) {
  const std::array<glm::dvec3, 14> rays = directions();
  std::array<Hit, 14> hits{};
  const SceneState state = state_at(scene, Time{});
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    std::vector<glm::dvec3> corners;
    corners.reserve(mesh.positions.size());
    for (const glm::vec3& p : mesh.positions)
      corners.push_back(state.stage_from_object[i](Point<Object>{glm::dvec3(p)}).v);
    for (const glm::uvec3& t : mesh.triangles)
      for (std::size_t ray = 0; ray < rays.size(); ++ray)
        meet(eye, rays[ray], corners[t.x], corners[t.y], corners[t.z], hits[ray]);
  }
  return static_cast<std::size_t>(std::ranges::count(hits, true, &Hit::faces));
}

}  // namespace

Rigid<Stage, Eye> viewpoint_of(const Scene& scene) {
  if (scene.camera) return *scene.camera;
  const glm::dvec3 low = scene.bounds.low, high = scene.bounds.high, middle = (low + high) * 0.5;
  const glm::dvec3 inside(middle.x, std::min(low.y + kEyeHeight_m, middle.y), middle.z);
  if (facing(scene, inside) >= kFacing) return {.translation = inside};
  // The scene's sphere fills three quarters of a view that is 80 degrees wide.
  const double radius = std::max(glm::length(high - low) * 0.5, 1e-6);
  const glm::dvec3 back = glm::normalize(glm::dvec3(0.25, 0.35, 1));
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back));
  return {.rotation = glm::normalize(glm::quat_cast(glm::dmat3(right, glm::cross(back, right), back))),
          .translation = middle + back * (2.0 * radius)};
}

}  // namespace farshade
