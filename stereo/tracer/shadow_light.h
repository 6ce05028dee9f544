/// A light as shadow rays need it: in float, in anchor space.
#pragma once

#include <algorithm>
#include <cmath>

#include "stereo/tracer/ray_packet.h"
#include "stereo/tracer/surface_model.h"

namespace farshade {

struct ShadowLight {
  LightKind kind = LightKind::Point;
  bool on = true;
  FloatPoint<Anchor> position{};    ///< point and spot lights
  FloatVector<Anchor> direction{};  ///< unit; the direction in which the light travels
  float reach = 0;                  ///< largest absolute coordinate of position
  float range = kFar;               ///< metres
  float cos_outer = -2;             ///< below -1: no cone
};

inline ShadowLight shadow_light(const Light& light, const SurfaceModel& model) {
  ShadowLight result{.kind = light.kind, .on = light.on, .direction = {glm::vec3(light.direction.v)}};
  if (light.kind == LightKind::Directional) return result;
  const Point<Anchor> position = model.anchor_from_stage()(light.position);
  result.position = in_float(position);
  result.reach =
      static_cast<float>(std::max({std::abs(position.v.x), std::abs(position.v.y), std::abs(position.v.z)}));
  if (light.range_m > 0) result.range = light.range_m;
  if (light.kind == LightKind::Spot) result.cos_outer = std::cos(light.outer_cone_rad);
  return result;
}

}  // namespace farshade
