#include "stereo/scene/lighting.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

#include "stereo/frame/eye_mask.h"
#include "stereo/scene/scene_hash.h"
#include "stereo/scene/scene_state.h"
#include "stereo/scene/sky.h"
#include "stereo/scene/viewpoint.h"

namespace farshade {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

// The chosen lighting of a scene without lights: white surfaces that face the sun are almost white.
constexpr double kSunAzimuth_deg = 145, kSunElevation_deg = 50;
constexpr float kDefaultAmbient = 0.06f;
constexpr double kLamp = 1.2,
                 kLampDistance = 0.65;  ///< its irradiance at this distance, in radii of the scene

/// A lamp up and to the left of where the head starts.
AddedLight lamp(const Scene& scene) {
  const Bounds bounds = bounds_without_sky(scene);
  const double distance = kLampDistance * std::max(glm::length(bounds.high - bounds.low) * 0.5, 1e-6);
  AddedLight light;
  light.source.name = "lamp";
  light.position = viewpoint_of(scene)(Point<Eye>{glm::dvec3(-0.1, 0.1, 0) * distance});
  light.source.intensity = glm::vec3(static_cast<float>(kLamp * distance * distance));
  return light;
}

/// A rotation that turns -z to `direction`, which is unit.
glm::dquat toward(const glm::dvec3& direction) {
  const glm::dvec3 side = std::abs(direction.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  return glm::quatLookAt(direction, side);
}

void add(const AddedLight& light, Scene& scene) {
  Node node;
  node.name = light.source.name;
  node.rest.translation = light.position.v;
  node.rest.rotation = toward(light.direction.v);
  LightSource source = light.source;
  source.node = static_cast<std::uint32_t>(scene.nodes.size());
  scene.nodes.push_back(std::move(node));
  scene.lights.push_back(std::move(source));
}

void expose(float exposure, LightSource& light) {
  light.intensity = glm::min(light.intensity * exposure, glm::vec3(1e30f));
  if (light.animation) light.animation->exposure *= exposure;
}

}  // namespace

AddedLight sun_light(double azimuth_deg, double elevation_deg, float lux) {
  const double azimuth = azimuth_deg * kRadians, elevation = elevation_deg * kRadians;
  const glm::dvec3 to_sun(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                          -std::cos(azimuth) * std::cos(elevation));
  AddedLight light;
  light.source.name = "sun";
  light.source.kind = LightKind::Directional;
  light.source.intensity = glm::vec3(lux);
  light.direction.v = -to_sun;
  return light;
}

Expected<LitScene> light_scene(Scene scene, const Lighting& lighting) {
  LitScene lit{std::move(scene), {}};
  Scene& made = lit.scene;
  const bool has_camera = made.camera.has_value();
  if (!has_camera) made.camera = viewpoint_of(made);
  for (const std::string& warning : made.warnings) lit.notes.push_back(made.name + ": " + warning);
  const bool was_dark = made.lights.empty() && lighting.lights.empty();
  for (const AddedLight& light : lighting.lights) add(light, made);
  if (was_dark) {
    add(sun_light(kSunAzimuth_deg, kSunElevation_deg, kSun_lux), made);
    add(lamp(made), made);
    lit.notes.push_back(fmt::format(
        "{} has no lights: it gets a sun and a lamp (--light and --sun choose others)", made.name));
  }
  if (made.lights.size() > kMaxLights)
    return fail(Fault::OutOfRange,
                fmt::format("{} lights with those of the command line, at most {} can be told apart",
                            made.lights.size(), kMaxLights));
  made.ambient = lighting.ambient.value_or(was_dark ? kDefaultAmbient : 0.0f);
  const float exposure = lighting.exposure.value_or(1.0f);
  if (exposure != 1.0f) {
    for (LightSource& light : made.lights) expose(exposure, light);
    made.ambient *= exposure;
  }
  if (!has_camera || !lighting.lights.empty() || was_dark || made.ambient != 0 || exposure != 1.0f)
    made.hash = hash_of(made);
  return lit;
}

}  // namespace farshade
