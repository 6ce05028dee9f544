/// Anchor space: the axes of the stage, with the origin at the scene's anchor (closeup.h). The tracer
/// computes in float in this space, so that a scene far from the stage's origin keeps its precision.
///
/// Set-up code has these types. The arrays of pixels and rays (tile_surface.h, ray_packet.h) hold raw floats,
/// always in anchor space.
#pragma once

#include <glm/vec3.hpp>

#include "stereo/math/spaces.h"

namespace farshade {

struct Anchor;

/// A point, rounded to float.
template <class Space>
struct FloatPoint {
  glm::vec3 v{0.0f};
  friend bool operator==(const FloatPoint&, const FloatPoint&) = default;
};

/// A direction, rounded to float.
template <class Space>
struct FloatVector {
  glm::vec3 v{0.0f};
  friend bool operator==(const FloatVector&, const FloatVector&) = default;
};

template <class Space>
[[nodiscard]] FloatPoint<Space> in_float(Point<Space> p) {
  return {glm::vec3(p.v)};
}

/// A translation: directions are the same in both spaces.
[[nodiscard]] inline Rigid<Anchor, Stage> anchor_from_stage(Point<Stage> anchor) {
  return {glm::dquat(1.0, 0.0, 0.0, 0.0), -anchor.v};
}

}  // namespace farshade
