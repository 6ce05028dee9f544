#include "stereo/math/fov.h"

#include <cmath>
#include <numbers>

namespace farshade {

bool is_valid(const EyeFov& fov) {
  constexpr double limit = 89.5 * std::numbers::pi / 180.0;
  const auto inside = [](double angle) { return std::abs(angle) <= limit; };  // false for NaN
  return inside(fov.left_rad) && inside(fov.right_rad) && inside(fov.up_rad) && inside(fov.down_rad) &&
         fov.left_rad < fov.right_rad && fov.down_rad < fov.up_rad;
}

FovTangents tangents_of(const EyeFov& fov) {
  return {std::tan(fov.left_rad), std::tan(fov.right_rad), std::tan(fov.up_rad), std::tan(fov.down_rad)};
}

glm::dvec3 pixel_ray(const FovTangents& tangents, Extent size, glm::dvec2 pixel) {
  return {tangents.left_tan + (tangents.right_tan - tangents.left_tan) * pixel.x / size.width,
          tangents.up_tan + (tangents.down_tan - tangents.up_tan) * pixel.y / size.height, -1.0};
}

glm::dvec2 ray_pixel(const FovTangents& tangents, Extent size, const glm::dvec3& d) {
  return {(d.x / -d.z - tangents.left_tan) / (tangents.right_tan - tangents.left_tan) * size.width,
          (d.y / -d.z - tangents.up_tan) / (tangents.down_tan - tangents.up_tan) * size.height};
}

glm::dmat4 clip_from_eye(const FovTangents& tangents) {
  glm::dmat4 m(0.0);
  m[0][0] = 2.0 / (tangents.right_tan - tangents.left_tan);
  m[2][0] = (tangents.right_tan + tangents.left_tan) / (tangents.right_tan - tangents.left_tan);
  m[1][1] = -2.0 / (tangents.up_tan - tangents.down_tan);
  m[2][1] = -(tangents.up_tan + tangents.down_tan) / (tangents.up_tan - tangents.down_tan);
  m[3][2] = kNearPlane_m;
  m[2][3] = -1.0;
  return m;
}

}  // namespace farshade
