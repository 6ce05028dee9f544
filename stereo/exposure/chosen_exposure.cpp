#include "stereo/exposure/chosen_exposure.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <numbers>

#include "stereo/exposure/arriving_light.h"
#include "stereo/placement/head_test.h"
#include "stereo/scene/viewpoint.h"

namespace farshade {
namespace {

constexpr int kAround = 2048;     ///< rays from the viewpoint
constexpr int kPlacesAcross = 8;  ///< rays to places in the scene's box, along an axis
// The exposure is chosen outside of these limits of the median irradiance / pi.
constexpr double kDarkest = 0.02, kBrightest = 1.25, kChosen = 0.4;

/// All around, and to places in the box around the scene, which may look small.
std::vector<Ray> first_rays(const Point<Stage>& eye, const Bounds& box) {
  std::vector<Ray> rays;
  for (const Vector<Stage>& direction : directions_around(kAround)) rays.push_back({eye, direction});
  for (int i = 0; i < kPlacesAcross * kPlacesAcross * kPlacesAcross; ++i) {
    const glm::ivec3 place(i % kPlacesAcross, i / kPlacesAcross % kPlacesAcross,
                           i / (kPlacesAcross * kPlacesAcross));
    const glm::dvec3 part = (glm::dvec3(place) + 0.5) / double{kPlacesAcross};
    const glm::dvec3 way = box.low + part * (box.high - box.low) - eye.v;
    if (glm::length(way) > 0) rays.push_back({eye, {glm::normalize(way)}});
  }
  return rays;
}

/// From each point a ray to its seen side.
std::vector<Ray> next_rays(std::span<const SeenPoint> points) {
  const std::vector<Vector<Stage>> directions = directions_around(kAround);
  std::vector<Ray> rays;
  constexpr std::size_t kStride = 797;  // a prime, so that points side by side look elsewhere
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 d = directions[i * kStride % directions.size()].v;
    rays.push_back({points[i].at, {glm::dot(d, points[i].normal.v) < 0 ? -d : d}});
  }
  return rays;
}

double luminance(const glm::vec3& color) {
  return glm::dot(glm::dvec3(color), glm::dvec3(0.2126, 0.7152, 0.0722));
}

}  // namespace

Exposure chosen_exposure(const Surroundings& surroundings, const Scene& scene) {
  const Point<Stage> eye{viewpoint_of(scene).translation};
  std::vector<SeenPoint> points = seen_points(surroundings, first_rays(eye, surroundings.bounds()));
  const std::vector<SeenPoint> beyond = seen_points(surroundings, next_rays(points));
  // In turns, because a prefix is used.
  std::vector<SeenPoint> all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    all.push_back(points[i]);
    if (i < beyond.size()) all.push_back(beyond[i]);
  }
  const ArrivingLight light(surroundings, scene, std::move(all));
  std::vector<double> lit;
  for (std::size_t i = 0; i < light.points().size(); ++i)
    if (const double shown = luminance(light.irradiance(i)) / std::numbers::pi; shown > 0)
      lit.push_back(shown);
  if (lit.empty()) return {};
  const auto middle = lit.begin() + static_cast<std::ptrdiff_t>(lit.size() / 2);
  std::ranges::nth_element(lit, middle);
  if (*middle >= kDarkest && *middle <= kBrightest) return {};
  const double stops = std::round(4 * std::log2(kChosen / *middle));
  return {
      static_cast<int>(std::clamp<double>(stops, -Exposure::kMostQuarterStops, Exposure::kMostQuarterStops))};
}

Exposure chosen_exposure(const Scene& scene) {
  const Expected<Surroundings> surroundings =
      Surroundings::create(scene, {.most_triangles = ~std::uint64_t{0}});
  return surroundings ? chosen_exposure(*surroundings, scene) : Exposure{};
}

std::string in_words(const Exposure& exposure, const std::string& scene_name) {
  if (exposure == Exposure{}) return {};
  return fmt::format(
      "{} would be too {}: all lights are multiplied by {:.3g} (--exposure sets another factor)", scene_name,
      exposure.quarter_stops > 0 ? "dark" : "bright", exposure.factor());
}

}  // namespace farshade
