/// SurfaceDistance: the nearest point of a triangle mesh, by Embree's point queries.
#pragma once

#include <memory>
#include <span>

#include "stereo/scene/scene.h"

struct RTCSceneTy;

namespace farshade {

struct ReleaseEmbreeScene {
  void operator()(RTCSceneTy* scene) const;
};

struct NearestPoint {
  float distance = 0;
  std::uint32_t triangle = 0;
  glm::vec3 weights{0.0f};  ///< barycentric, of the triangle's corners
};

/// The point of the triangle a, b, c that is nearest to p, as barycentric weights (C. Ericson, "Real-Time
/// Collision Detection", 2005, section 5.1.5).
[[nodiscard]] glm::vec3 nearest_weights(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b,
                                        const glm::vec3& c);

class SurfaceDistance {
 public:
  /// Keeps the references. There is at least one triangle.
  SurfaceDistance(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles);

  /// The nearest point. Faster the closer `guess`, a distance above 0, is above the result.
  [[nodiscard]] NearestPoint nearest(const glm::vec3& p, float guess) const;

  /// The distance to the surface if it is greater than `enough`; otherwise a value of at most `enough`.
  [[nodiscard]] float distance_above(const glm::vec3& p, float enough, float guess) const;

 private:
  struct Query;
  [[nodiscard]] NearestPoint search(const glm::vec3& p, float enough, float guess) const;

  std::span<const glm::vec3> positions_;
  std::span<const glm::uvec3> triangles_;
  std::unique_ptr<RTCSceneTy, ReleaseEmbreeScene> scene_;
};

}  // namespace farshade
