#include "tests/golden/reproject_reference.h"

#include <algorithm>
#include <cmath>

namespace farshade {
namespace {

constexpr double kPlain =
    4e-6;  ///< the second differences of 1/d on a plane stay below this share of 1/d: 64 ulps
constexpr double kBorder_px =
    0.02;  ///< a point this close to the border of a pixel may count to either pixel
constexpr double kGrazing =
    0.05;  ///< sine of the smallest angle at which the result is compared: normals have 8 bits
constexpr double kClear = 2;

double inverse_distance(const EyeDepth& depth, std::int64_t x, std::int64_t y) {
  const float distance = depth.distance_m.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
  return distance > 0 ? 1.0 / distance : 0.0;
}

glm::dvec3 ray(const View& view, double x, double y) {
  return pixel_ray(tangents_of(view.fov), view.size, {x, y});
}

/// The plane m . p = 1 of the shown eye's space that contains pixel (x, y) and its eight neighbours. No value
/// if they lie in no plane.
std::optional<glm::dvec3> plane_about(const EyeDepth& depth, std::uint32_t x, std::uint32_t y) {
  const Extent size = depth.view.size;
  if (x == 0 || y == 0 || x + 1 >= size.width || y + 1 >= size.height) return std::nullopt;
  const double middle = inverse_distance(depth, x, y);
  const auto at = [&](int dx, int dy) {
    return inverse_distance(depth, std::int64_t{x} + dx, std::int64_t{y} + dy);
  };
  for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}})
    if (std::abs(at(dx, dy) + at(-dx, -dy) - 2 * middle) > kPlain * middle) return std::nullopt;
  const glm::dvec3 r = ray(depth.view, x + 0.5, y + 0.5), next = ray(depth.view, x + 1.5, y + 1.5);
  const double mx = (at(1, 0) - at(-1, 0)) / 2 / (next.x - r.x),
               my = (at(0, 1) - at(0, -1)) / 2 / (next.y - r.y);
  return glm::dvec3(mx, my, mx * r.x + my * r.y - middle);
}

bool is_near_border(double position) {
  return std::abs(position - std::round(position)) < kBorder_px;
}

/// The width in metres of a pixel's footprint at distance 1.
double footprint(const View& view) {
  const glm::dvec3 step = ray(view, 1, 1) - ray(view, 0, 0);
  return std::max(std::abs(step.x), std::abs(step.y));
}

}  // namespace

std::optional<ReprojectedPixel> reproject(const EyeDepth& shown, std::uint32_t x, std::uint32_t y,
                                          const View& traced) {
  const double distance = shown.distance_m.at(x, y);
  if (!(distance > 0)) return std::nullopt;
  const Rigid<Eye, Eye> traced_from_shown = inverse(traced.stage_from_eye) * shown.view.stage_from_eye;
  const glm::dvec3 point = traced_from_shown(Point<Eye>{ray(shown.view, x + 0.5, y + 0.5) * distance}).v;
  if (point.z >= 0) return std::nullopt;
  return ReprojectedPixel{point, ray_pixel(tangents_of(traced.fov), traced.size, point)};
}

bool is_inside(const glm::dvec2& at, Extent size) {
  return at.x >= 0 && at.y >= 0 && at.x < size.width && at.y < size.height;
}

SameSurface same_surface(const EyeDepth& shown, std::uint32_t x, std::uint32_t y, const EyeDepth& traced) {
  const std::optional<ReprojectedPixel> reprojected = reproject(shown, x, y, traced.view);
  if (!reprojected) return SameSurface::No;
  const glm::dvec2 at = reprojected->at;
  const bool near_border = is_near_border(at.x) || is_near_border(at.y);
  if (!is_inside(at, traced.view.size)) return near_border ? SameSurface::Unclear : SameSurface::No;
  if (near_border) return SameSurface::Unclear;

  const std::optional<glm::dvec3> m = plane_about(shown, x, y);
  if (!m) return SameSurface::Unclear;
  // A point p of the shown eye is T p = R p + t in the traced eye. So m . p = 1 becomes (R m) . p = 1 + (R m)
  // . t.
  const Rigid<Eye, Eye> t = inverse(traced.view.stage_from_eye) * shown.view.stage_from_eye;
  const glm::dvec3 rm = t.rotation * *m;
  const double from_eye = 1 + glm::dot(rm, t.translation);
  const double sine = from_eye / (glm::length(rm) * glm::length(reprojected->point));
  if (sine < -kGrazing) return SameSurface::No;
  if (sine < kGrazing) return SameSurface::Unclear;

  const glm::dvec2 pixel = glm::floor(at);
  const double seen =
      inverse_distance(traced, static_cast<std::int64_t>(pixel.x), static_cast<std::int64_t>(pixel.y));
  const double expected = glm::dot(rm, ray(traced.view, pixel.x + 0.5, pixel.y + 0.5)) / from_eye;
  const double of_point = -1 / reprojected->point.z;
  const double apart = std::abs(seen - expected),
               allowed = 0.5 * std::abs(expected - of_point) + footprint(traced.view) * of_point;
  if (apart * kClear < allowed) return SameSurface::Yes;
  return apart > kClear * allowed ? SameSurface::No : SameSurface::Unclear;
}

EyeMask reprojected_without_test(const EyeDepth& shown, const View& traced, const EyeMask& bits) {
  const Extent size = shown.view.size;
  EyeMask result(size, bits.lights());
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) {
      const std::optional<ReprojectedPixel> reprojected = reproject(shown, x, y, traced);
      const bool seen = reprojected && is_inside(reprojected->at, traced.size);
      for (std::uint32_t plane = 0; plane < bits.layout().planes(); ++plane)
        result.set_word(x, y, plane,
                        seen ? bits.word(static_cast<std::uint32_t>(reprojected->at.x),
                                         static_cast<std::uint32_t>(reprojected->at.y), plane)
                             : bits.layout().used_bits(plane));
    }
  return result;
}

}  // namespace farshade
