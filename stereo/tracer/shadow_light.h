/// A light as shadow rays need it: in float, about the model's anchor.
#pragma once

#include <algorithm>
#include <cmath>

#include "stereo/tracer/ray_packet.h"
#include "stereo/tracer/surface_model.h"

namespace farshade {

struct ShadowLight {
  LightKind kind = LightKind::Point;
  bool on = true;
  glm::vec3 position{0.0f};   ///< anchor-relative
  glm::vec3 direction{0.0f};  ///< unit, the way the light travels
  float reach = 0;            ///< largest absolute coordinate of position
  float range = kFar;         ///< metres
  float cos_outer = -2;       ///< below -1: no cone
};

inline ShadowLight shadow_light(const Light& light, const SurfaceModel& model) {
  const glm::dvec3 position = light.position.v - model.anchor();
  const double reach = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
  ShadowLight result{.kind = light.kind, .on = light.on, .direction = glm::vec3(light.direction.v)};
  if (light.kind == LightKind::Directional) return result;
  result.position = glm::vec3(position);
  result.reach = static_cast<float>(reach);
  if (light.range_m > 0) result.range = light.range_m;
  if (light.kind == LightKind::Spot) result.cos_outer = std::cos(light.outer_cone_rad);
  return result;
}

}  // namespace farshade
