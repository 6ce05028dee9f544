/// The field of view of an eye, as angles (OpenXR's form) and as tangents, and the projection it defines. The
/// field of view may be asymmetric.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "stereo/base/extent.h"

namespace farshade {

/// The angles between the view axis and the four sides of the picture. For a symmetric eye, left and down are
/// negative.
struct EyeFov {
  double left_rad = 0, right_rad = 0, up_rad = 0, down_rad = 0;
  friend bool operator==(const EyeFov&, const EyeFov&) = default;
};

/// True if all angles are finite and within +-89.5 degrees, left < right, and down < up.
[[nodiscard]] bool is_valid(const EyeFov& fov);

/// The tangents of the four angles: where the sides of the picture cross the plane z = -1 of the eye space.
struct FovTangents {
  double left_tan = 0, right_tan = 0, up_tan = 0, down_tan = 0;
  friend bool operator==(const FovTangents&, const FovTangents&) = default;
};
[[nodiscard]] FovTangents tangents_of(const EyeFov& fov);

/// The eye-space point (x, y, -1) on the ray through a pixel position. Row 0 is the top row; pixel centres
/// are at +0.5.
[[nodiscard]] glm::dvec3 pixel_ray(const FovTangents& tangents, Extent size, glm::dvec2 pixel);

/// The pixel position of the eye-space direction (x, y, z), z < 0. Inverse of pixel_ray.
[[nodiscard]] glm::dvec2 ray_pixel(const FovTangents& tangents, Extent size, const glm::dvec3& direction);

/// Distance of the near plane, metres. The depth value is near / distance (reversed z, infinite far plane):
/// the relative precision of a float is the same at every distance, so the near plane may be this close.
/// Source: E. Lapidous and G. Jiao, "Optimal depth buffer for low-cost graphics hardware", 1999.
inline constexpr double kNearPlane_m = 1e-4;

/// Vulkan clip space (y down, depth 1 at the near plane, 0 at infinity) from eye space.
[[nodiscard]] glm::dmat4 clip_from_eye(const FovTangents& tangents);

}  // namespace farshade
