#include "stereo/frame/hidden_area.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <span>

namespace farshade {
namespace {

/// The widest side of the guard band of both eyes, but at least kLeastTurn_deg.
double turn_rad(const StereoView& shown, const StereoView& requested) {
  double turn = glm::radians(kLeastTurn_deg);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const EyeFov &inner = shown[eye].fov, &outer = requested[eye].fov;
    turn = std::max({turn, inner.left_rad - outer.left_rad, outer.right_rad - inner.right_rad,
                     outer.up_rad - inner.up_rad, inner.down_rad - outer.down_rad});
  }
  return turn;
}

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// Of the origin from the line between two points.
double distance_from(const glm::dvec2& a, const glm::dvec2& b) {
  const glm::dvec2 along = b - a;
  const double length2 = glm::dot(along, along);
  const double part = length2 > 0 ? std::clamp(-glm::dot(a, along) / length2, 0.0, 1.0) : 0.0;
  return glm::length(a + along * part);
}

/// Of the origin from a triangle; 0 inside.
double distance_from(std::span<const glm::vec2, 3> triangle) {
  const glm::dvec2 a(triangle[0]), b(triangle[1]), c(triangle[2]);
  const double ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
  if ((ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0)) return 0;
  return std::min({distance_from(a, b), distance_from(b, c), distance_from(c, a)});
}

/// The factor by which a turn moves a point away that lies at this distance from the axis. Infinite: out of
/// the plane.
double factor_at(double distance, double turn) {
  const double angle = std::atan(distance) + turn;
  const bool in_plane = distance > 0 && angle < glm::radians(89.0);
  return in_plane ? std::tan(angle) / distance : std::numeric_limits<double>::infinity();
}

/// Of the origin from the corner of the view that is farthest from it.
double corner_of(const EyeFov& fov) {
  return glm::length(glm::dvec2(std::tan(std::max(-fov.left_rad, fov.right_rad)),
                                std::tan(std::max(fov.up_rad, -fov.down_rad))));
}

/// The factor has its minimum between the ends of the area, so that one of the ends needs the largest. What
/// lies outside of the view does not matter.
double scale_of(const HiddenArea& area, double turn, double view_end) {
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
  for (std::size_t first = 0; first + 3 <= area.corners.size(); first += 3)
    nearest = std::min(nearest, distance_from(std::span(area.corners).subspan(first).first<3>()));
  for (const glm::vec2& corner : area.corners) farthest = std::max(farthest, glm::length(glm::dvec2(corner)));
  farthest = std::min(farthest, std::max(nearest, view_end));
  return std::max(factor_at(nearest, turn), factor_at(farthest, turn));
}

}  // namespace

PerEye<HiddenArea> hidden_in_request(const PerEye<HiddenArea>& hidden, const StereoView& shown,
                                     const StereoView& requested) {
  const double turn = turn_rad(shown, requested);
  const double view_end = std::max(corner_of(requested[0].fov), corner_of(requested[1].fov));
  PerEye<HiddenArea> scaled = hidden;
  for (HiddenArea& area : scaled) {
    const double scale = scale_of(area, turn, view_end);
    if (!std::isfinite(scale)) area.corners.clear();
    for (glm::vec2& corner : area.corners) corner = glm::vec2(glm::dvec2(corner) * scale);
  }
  return scaled;
}

}  // namespace farshade
