/// ArrivingLight: which light arrives at points that somebody sees, at time 0: by the lights' own strength,
/// and by what stands in their way. Animated lights are as bright as they ever get.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "stereo/placement/surroundings.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

/// As in the shader: prevents infinity, which becomes NaN.
inline constexpr float kMostIrradiance = 1e30f;

/// A point of a surface, and the side of it that is seen.
struct SeenPoint {
  Point<Stage> at;
  Vector<Stage> normal;        ///< unit, to the side that is seen
  std::uint32_t instance = 0;  ///< into Scene::instances
};

/// The points that the rays meet first, and can be seen. Rays that meet nothing add none.
[[nodiscard]] std::vector<SeenPoint> seen_points(const Surroundings& surroundings, std::span<const Ray> rays);

/// The light of one light at one point.
struct Arrival {
  glm::vec3 irradiance{0.0f};                           ///< if nothing blocks it; 0 behind the surface
  std::optional<std::uint32_t> blocker = std::nullopt;  ///< the instance that the shadow ray meets first

  [[nodiscard]] glm::vec3 arriving() const { return blocker ? glm::vec3(0.0f) : irradiance; }
};

class ArrivingLight {
 public:
  /// At most this many points and lights are combined; a prefix of more points is used.
  static constexpr std::size_t kMostArrivals = std::size_t{1} << 18;

  ArrivingLight(const Surroundings& surroundings, const Scene& scene, std::vector<SeenPoint> points);

  [[nodiscard]] std::span<const SeenPoint> points() const { return points_; }
  [[nodiscard]] std::size_t lights() const { return lights_; }
  /// The arrivals of all lights at a point.
  [[nodiscard]] std::span<const Arrival> at(std::size_t point) const {
    return std::span(arrivals_).subspan(point * lights_, lights_);
  }
  /// Irradiance of all lights at a point.
  [[nodiscard]] glm::vec3 irradiance(std::size_t point) const;

 private:
  std::vector<SeenPoint> points_;
  std::size_t lights_;
  std::vector<Arrival> arrivals_;  ///< lights of a point in a row
};

}  // namespace farshade
