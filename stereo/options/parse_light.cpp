#include "stereo/options/parse_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "stereo/options/option_words.h"

namespace farshade {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

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
  return sun_light(values[0], values[1], static_cast<float>(lux));
}

}  // namespace farshade
