#include "tests/stability/thin.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

namespace farshade::stability {
namespace {

/// The distance of an edge from a pixel position, and its distance along -z there. No value if the edge
/// reaches behind the eye.
struct Pass {
  double off_px, distance_m;
};

std::optional<Pass> pass(const glm::dvec3& a, const glm::dvec3& b, const View& view,
                         const glm::dvec2& at_px) {
  const Rigid<Eye, Stage> eye_from_stage = inverse(view.stage_from_eye);
  const glm::dvec3 p = eye_from_stage(Point<Stage>{a}).v, q = eye_from_stage(Point<Stage>{b}).v;
  if (p.z >= 0 || q.z >= 0) return std::nullopt;
  const FovTangents window = tangents_of(view.fov);
  const glm::dvec2 from = ray_pixel(window, view.size, p), along = ray_pixel(window, view.size, q) - from;
  const double length2 = glm::dot(along, along);
  const double t = length2 > 0 ? std::clamp(glm::dot(at_px - from, along) / length2, 0.0, 1.0) : 0.0;
  // Inverse distance is linear on the screen.
  return Pass{glm::length(from + along * t - at_px), 1 / (-1 / p.z * (1 - t) - 1 / q.z * t)};
}

}  // namespace

std::vector<Corners> triangles_of(const Scene& scene, const SceneState& state) {
  std::vector<Corners> all;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    for (const glm::uvec3& t : mesh.triangles) {
      Corners corners;
      for (int k = 0; k < 3; ++k)
        corners[static_cast<std::size_t>(k)] =
            state.stage_from_object[i](Point<Object>{glm::dvec3(mesh.positions[t[k]])}).v;
      all.push_back(corners);
    }
  }
  return all;
}

bool is_other(double distance_m, const Met* met) {
  if (met == nullptr) return distance_m > 0;
  return std::abs(distance_m - met->distance_m) > kSameDistance * met->distance_m;
}

bool may_be_seen(double distance_m, const Met* met, const View& view, const glm::dvec2& centre_px,
                 const std::vector<Corners>& triangles) {
  const auto edge_passes = [&](const Corners& corners, double at_m) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto passed = pass(corners[i], corners[(i + 1) % 3], view, centre_px);
      if (passed && passed->off_px <= kGrid_px &&
          (at_m == 0 || std::abs(passed->distance_m - at_m) <= 0.01 * at_m))
        return true;
    }
    return false;
  };
  const bool before = distance_m > 0 && (met == nullptr || distance_m < met->distance_m);
  if (!before) return edge_passes(met->corners, 0);
  return std::ranges::any_of(triangles, [&](const Corners& c) { return edge_passes(c, distance_m); });
}

}  // namespace farshade::stability
