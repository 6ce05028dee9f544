/// Field of view as OpenXR states it: four angles, never assumed symmetric, and the projection they make.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace farshade {

struct Extent {
  std::uint32_t width = 0, height = 0;  ///< pixels
  friend bool operator==(Extent, Extent) = default;
  [[nodiscard]] constexpr std::size_t pixels() const { return std::size_t{width} * height; }
};

/// Radians; left and down are negative for a symmetric eye.
struct EyeFov {
  double left = 0, right = 0, up = 0, down = 0;
  friend bool operator==(const EyeFov&, const EyeFov&) = default;
};

/// Finite, left < right, down < up, all within +-89.5 degrees.
[[nodiscard]] bool is_valid(const EyeFov& fov);

/// The fov's window on the plane z = -1.
struct EyeWindow {
  double left = 0, right = 0, up = 0, down = 0;
  friend bool operator==(const EyeWindow&, const EyeWindow&) = default;
};
[[nodiscard]] EyeWindow window_of(const EyeFov& fov);

/// The eye-space point (x, y, -1) that pixel position (px, py) looks at. Row 0 is the top; centres are at
/// +0.5.
[[nodiscard]] glm::dvec3 pixel_ray(const EyeWindow& window, Extent size, glm::dvec2 pixel);

/// Pixel position of the eye-space direction (x, y, z), z < 0. Inverse of pixel_ray.
[[nodiscard]] glm::dvec2 ray_pixel(const EyeWindow& window, Extent size, const glm::dvec3& direction);

/// Near plane, metres. The depth value is near / distance: reversed z, infinite far plane, so float's
/// relative precision is the same at every distance (Lapidous and Jiao, "Optimal depth buffer for low-cost
/// graphics hardware", 1999) and the plane may lie this close.
inline constexpr double kNearPlane_m = 1e-4;

/// Vulkan clip space (y down, depth 1 at the near plane, 0 at infinity) from eye space.
[[nodiscard]] glm::dmat4 clip_from_eye(const EyeWindow& window);

}  // namespace farshade
