#include "stereo/exposure/arriving_light.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace farshade {
namespace {

constexpr double kSurfaceOffset = 1e-4;  ///< of a point's distance to the eye that sees it
/// Where the float positions of the whole scene may be off.
constexpr double kRounding = 1e-6;

/// Irradiance of a light without shadows, as the shader computes it (shade.comp), but not limited.
glm::vec3 unlimited_irradiance(const Light& light, const SeenPoint& point) {
  const bool directional = light.kind == LightKind::Directional;
  const glm::dvec3 to_light = directional ? -light.direction.v : light.position.v - point.at.v;
  const double distance2 = glm::dot(to_light, to_light);
  if (!light.on || !(distance2 > 0)) return glm::vec3(0.0f);
  const glm::dvec3 l = to_light / std::sqrt(distance2);
  double strength = std::max(glm::dot(point.normal.v, l), 0.0);
  if (directional) return light.intensity * static_cast<float>(strength);
  if (light.range_m > 0) {
    const double reach = distance2 / (double{light.range_m} * light.range_m);
    strength *= std::clamp(1 - reach * reach, 0.0, 1.0);
  }
  if (light.kind == LightKind::Spot) {
    const double inner = std::cos(light.inner_cone_rad), outer = std::cos(light.outer_cone_rad);
    const double falloff =
        std::clamp((-glm::dot(light.direction.v, l) - outer) / std::max(0.001, inner - outer), 0.0, 1.0);
    strength *= falloff * falloff;
  }
  return light.intensity * static_cast<float>(strength / distance2);
}

glm::vec3 irradiance_of(const Light& light, const SeenPoint& point) {
  return glm::min(unlimited_irradiance(light, point), kMostIrradiance);
}

/// The lights at time 0, each as bright as it ever gets.
std::vector<Light> brightest_lights(const Scene& scene) {
  std::vector<Light> lights = state_at(scene, Time{}).light_set.lights;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    lights[i].intensity = scene.lights[i].intensity;
    lights[i].on = true;
  }
  return lights;
}

}  // namespace

std::vector<SeenPoint> seen_points(const Surroundings& surroundings, std::span<const Ray> rays) {
  const std::vector<Met> met = surroundings.first_seen(rays);
  const double rounding = kRounding * glm::length(surroundings.bounds().high - surroundings.bounds().low);
  std::vector<SeenPoint> points;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (met[i].distance_m == kNoSurface_m) continue;
    const Ray& ray = rays[i];
    const bool back = glm::dot(ray.direction.v, met[i].normal.v) > 0;
    const Vector<Stage> normal{back ? -met[i].normal.v : met[i].normal.v};
    const double above = kSurfaceOffset * met[i].distance_m + rounding;
    points.push_back(
        {{ray.origin.v + ray.direction.v * met[i].distance_m + normal.v * above}, normal, met[i].instance});
  }
  return points;
}

ArrivingLight::ArrivingLight(const Surroundings& surroundings, const Scene& scene,
                             std::vector<SeenPoint> points)
    : points_(std::move(points)), lights_(scene.lights.size()) {
  if (lights_ == 0) return;
  points_.resize(std::min(points_.size(), kMostArrivals / lights_));
  const std::vector<Light> lights = brightest_lights(scene);
  std::vector<Ray> rays;
  std::vector<std::size_t> ray_of;  // into arrivals_
  std::vector<double> length_m;
  for (const SeenPoint& point : points_)
    for (const Light& light : lights) {
      arrivals_.push_back({.irradiance = irradiance_of(light, point)});
      if (arrivals_.back().irradiance == glm::vec3(0.0f)) continue;
      const bool directional = light.kind == LightKind::Directional;
      const glm::dvec3 way = directional ? -light.direction.v : light.position.v - point.at.v;
      rays.push_back({point.at, {glm::normalize(way)}});
      ray_of.push_back(arrivals_.size() - 1);
      length_m.push_back(directional ? kNoSurface_m : glm::length(way));
    }
  const std::vector<Met> met = surroundings.first_met(rays);
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (met[i].distance_m < length_m[i]) arrivals_[ray_of[i]].blocker = met[i].instance;
}

glm::vec3 ArrivingLight::irradiance(std::size_t point) const {
  glm::vec3 sum(0.0f);
  for (const Arrival& arrival : at(point)) sum += arrival.arriving();
  return sum;
}

}  // namespace farshade
