#include "stereo/scene/lighting.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

#include "stereo/scene/option_words.h"
#include "stereo/scene/scene_hash.h"
#include "stereo/scene/scene_state.h"
#include "stereo/scene/sky.h"
#include "stereo/scene/viewpoint.h"

namespace farshade {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

// The chosen lighting of a scene without lights: white surfaces that face the sun are almost white.
constexpr double kSunAzimuth_deg = 145, kSunElevation_deg = 50;
constexpr float kSun_lux = 2.2f, kDefaultAmbient = 0.06f;
constexpr double kLamp = 1.2,
                 kLampDistance = 0.65;  ///< its irradiance at this distance, in radii of the scene

std::optional<glm::dvec3> vector(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, ':');
  if (parts.size() != 3) return std::nullopt;
  glm::dvec3 v;
  for (int i = 0; i < 3; ++i) {
    const std::optional<double> value = number_in(parts[static_cast<std::size_t>(i)]);
    if (!value || std::abs(*value) > 1e9) return std::nullopt;
    v[i] = *value;
  }
  return v;
}

bool has_length(const glm::dvec3& v) {
  return glm::length(v) > 1e-9;
}

/// What the words of --light say, before they are combined.
struct LightWords {
  std::optional<glm::dvec3> at, to, along, color;
  std::optional<double> candela, lux, range, cone, inner;
};

bool read(std::string_view name, std::string_view value, LightWords& words) {
  const auto set = [](auto& to, auto read_value) {
    to = read_value;
    return to.has_value();
  };
  if (name == "at") return set(words.at, vector(value));
  if (name == "to") return set(words.to, vector(value));
  if (name == "along") return set(words.along, vector(value));
  if (name == "color") return set(words.color, vector(value));
  if (name == "candela") return set(words.candela, number_in(value));
  if (name == "lux") return set(words.lux, number_in(value));
  if (name == "range") return set(words.range, number_in(value));
  if (name == "cone") return set(words.cone, number_in(value));
  if (name == "inner") return set(words.inner, number_in(value));
  return false;
}

Error bad_light(Fault fault, std::string_view text, std::string_view why) {
  return {fault, fmt::format("--light {}: {}; write for example point,at=0:2:1,candela=40 or "
                             "spot,at=0:3:0,to=0:0:0,cone=30,candela=100 or directional,along=0.3:-1:0,lux=3 "
                             "(more words: range=METRES, color=R:G:B, inner=DEGREES)",
                             text, why)};
}

Expected<AddedLight> light_from(std::string_view text, LightKind kind, const LightWords& words) {
  const auto wrong = [&](std::string_view why) {
    return tl::unexpected(bad_light(Fault::OutOfRange, text, why));
  };
  const bool directional = kind == LightKind::Directional, spot = kind == LightKind::Spot;
  if (directional ? words.candela.has_value() : words.lux.has_value())
    return wrong("point and spot lights have candela, directional lights have lux");
  if (!directional && !words.at) return wrong("it needs a place, at=X:Y:Z");
  if (directional && words.range) return wrong("a directional light has no range");
  if (!spot && (words.cone || words.inner)) return wrong("only a spot light has a cone");
  AddedLight light;
  light.source.name = "--light";
  light.source.kind = kind;
  if (words.at) light.position.v = *words.at;
  if (kind == LightKind::Point && (words.to || words.along)) return wrong("a point light has no direction");
  if (words.along) light.direction.v = *words.along;
  if (words.to) light.direction.v = *words.to - light.position.v;
  if (!has_length(light.direction.v)) return wrong("its direction has no length");
  light.direction.v = glm::normalize(light.direction.v);
  const double strength = directional ? words.lux.value_or(3) : words.candela.value_or(30);
  const glm::dvec3 color = words.color.value_or(glm::dvec3(1));
  if (!(strength > 0) || strength > 1e12 || std::min({color.r, color.g, color.b}) < 0)
    return wrong("intensity must be above 0, and no part of the colour below 0");
  light.source.intensity = glm::vec3(color * strength);
  if (words.range && !(*words.range > 0)) return wrong("its range must be above 0 m");
  if (words.range) light.source.range_m = static_cast<float>(*words.range);
  if (!spot) return light;
  const double outer = words.cone.value_or(45), inner = words.inner.value_or(outer * 0.8);
  if (!(outer > 0) || outer > 90 || inner < 0 || !(inner < outer))
    return wrong("cone is above 0 and at most 90 degrees from the axis, and inner is less");
  light.source.outer_cone_rad = static_cast<float>(outer * kRadians);
  light.source.inner_cone_rad = static_cast<float>(inner * kRadians);
  return light;
}

AddedLight sun(double azimuth_deg, double elevation_deg, float lux) {
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

Expected<AddedLight> parse_light(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, ',');
  const std::string_view kind = parts.front();
  if (kind != "point" && kind != "spot" && kind != "directional")
    return tl::unexpected(bad_light(Fault::Malformed, text, "it begins with point, spot or directional"));
  LightWords words;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const std::size_t equals = std::min(parts[i].find('='), parts[i].size());
    const std::string_view value = parts[i].substr(std::min(equals + 1, parts[i].size()));
    if (!read(parts[i].substr(0, equals), value, words))
      return tl::unexpected(bad_light(Fault::Malformed, text, fmt::format("'{}' cannot be read", parts[i])));
  }
  return light_from(text,
                    kind == "point"  ? LightKind::Point
                    : kind == "spot" ? LightKind::Spot
                                     : LightKind::Directional,
                    words);
}

Expected<AddedLight> parse_sun(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, ',');
  std::vector<double> values;
  for (const std::string_view part : parts)
    if (const std::optional<double> value = number_in(part)) values.push_back(*value);
  if (values.size() != parts.size() || values.size() < 2 || values.size() > 3)
    return fail(Fault::Malformed,
                fmt::format("--sun {}: write AZIMUTH,ELEVATION in degrees and perhaps LUX, for example "
                            "145,50,3; azimuth 0 is -z and 90 is +x",
                            text));
  const double lux = values.size() == 3 ? values[2] : double{kSun_lux};
  if (std::abs(values[1]) > 90 || std::abs(values[0]) > 360 || !(lux > 0) || lux > 1e12)
    return fail(Fault::OutOfRange,
                fmt::format("--sun {}: azimuth is -360 to 360 degrees, elevation -90 to 90, and "
                            "the light above 0 lux",
                            text));
  return sun(values[0], values[1], static_cast<float>(lux));
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
    add(sun(kSunAzimuth_deg, kSunElevation_deg, kSun_lux), made);
    add(lamp(made), made);
    lit.notes.push_back(fmt::format(
        "{} has no lights: it gets a sun and a lamp (--light and --sun choose others)", made.name));
  }
  if (made.lights.size() > SceneLimits{}.lights)
    return fail(Fault::OutOfRange,
                fmt::format("{} lights with those of the command line, at most {} can be told apart",
                            made.lights.size(), SceneLimits{}.lights));
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

Expected<LitScene> load_lit_scene(const std::filesystem::path& path, const Lighting& lighting,
                                  ListFiles list) try {
  return load_scene(path, {}, lighting.choice, list).and_then([&](Scene scene) {
    return light_scene(std::move(scene), lighting);
  });
} catch (const std::bad_alloc&) {
  return fail(Fault::Unavailable, path.string() + ": there is not enough memory for this scene");
}

}  // namespace farshade
