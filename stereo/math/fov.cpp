#include "stereo/math/fov.h"

#include <cmath>
#include <numbers>

namespace farshade {

bool is_valid(const EyeFov& fov) {
  constexpr double limit = 89.5 * std::numbers::pi / 180.0;
  const auto inside = [](double angle) { return std::abs(angle) <= limit; };  // false for NaN
  return inside(fov.left) && inside(fov.right) && inside(fov.up) && inside(fov.down) &&
         fov.left < fov.right && fov.down < fov.up;
}

EyeWindow window_of(const EyeFov& fov) {
  return {std::tan(fov.left), std::tan(fov.right), std::tan(fov.up), std::tan(fov.down)};
}

glm::dvec3 pixel_ray(const EyeWindow& w, Extent size, glm::dvec2 pixel) {
  return {w.left + (w.right - w.left) * pixel.x / size.width, w.up + (w.down - w.up) * pixel.y / size.height,
          -1.0};
}

glm::dvec2 ray_pixel(const EyeWindow& w, Extent size, const glm::dvec3& d) {
  return {(d.x / -d.z - w.left) / (w.right - w.left) * size.width,
          (d.y / -d.z - w.up) / (w.down - w.up) * size.height};
}

glm::dmat4 clip_from_eye(const EyeWindow& w) {
  glm::dmat4 m(0.0);
  m[0][0] = 2.0 / (w.right - w.left);
  m[2][0] = (w.right + w.left) / (w.right - w.left);
  m[1][1] = -2.0 / (w.up - w.down);
  m[2][1] = -(w.up + w.down) / (w.up - w.down);
  m[3][2] = kNearPlane_m;
  m[2][3] = -1.0;
  return m;
}

}  // namespace farshade
