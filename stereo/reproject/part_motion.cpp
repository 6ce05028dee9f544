#include "stereo/reproject/part_motion.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace farshade {
namespace {

constexpr std::size_t kSamples = 12;
constexpr double kLift = 0.25;  // of the part's half diagonal

/// Every second point is a lifted one. They only decide what the others leave open.
double weight_of(std::size_t point) {
  return point % 2 == 0 ? 1.0 : 0.02;
}

glm::dvec3 mean(const std::vector<glm::dvec3>& points) {
  glm::dvec3 sum(0.0);
  double weights = 0;
  for (std::size_t i = 0; i < points.size(); ++i) sum += points[i] * weight_of(i), weights += weight_of(i);
  return sum / weights;
}

/// The affine transform that maps `from` to `to` with the least weighted sum of squared errors. The
/// identity's linear part if the points determine none.
glm::dmat4 fitted(const std::vector<glm::dvec3>& from, const std::vector<glm::dvec3>& to) {
  const glm::dvec3 from_mean = mean(from), to_mean = mean(to);
  glm::dmat3 across(0.0), within(0.0);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const glm::dvec3 offset = (from[i] - from_mean) * weight_of(i);
    across += glm::outerProduct(to[i] - to_mean, offset);
    within += glm::outerProduct(from[i] - from_mean, offset);
  }
  const double size = within[0][0] + within[1][1] + within[2][2];
  const bool is_spread = glm::determinant(within) > 1e-9 * size * size * size;
  const glm::dmat3 linear = is_spread ? across * glm::inverse(within) : glm::dmat3(1.0);
  glm::dmat4 result(linear);
  result[3] = glm::dvec4(to_mean - linear * from_mean, 1.0);
  return result;
}

}  // namespace

PartMotion::PartMotion(const Scene& scene, std::uint32_t instance)
    : scene_(scene),
      instance_(instance),
      rig_(*scene.instances[instance].rig),
      bounds_(*scene.meshes[scene.instances[instance].mesh].deformable) {
  const Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
  const std::size_t count = std::min(kSamples, mesh.positions.size());
  for (std::size_t i = 0; i < count; ++i)
    vertices_.push_back(static_cast<std::uint32_t>(i * mesh.positions.size() / count));
  const Bounds box = bounds_of(mesh.positions);
  lift_ = kLift * 0.5 * glm::length(box.high - box.low);
}

std::vector<glm::dvec3> PartMotion::points(const SceneState& state) const {
  const Mesh& mesh = scene_.meshes[scene_.instances[instance_].mesh];
  const Deformation deformation(*mesh.deformable, state.rigs[rig_]);
  const Affine<Stage, Object>& stage_from_object = state.stage_from_object[instance_];
  std::vector<glm::dvec3> result;
  for (const std::uint32_t index : vertices_) {
    const DeformedVertex vertex = deformation.vertex(index);
    const glm::dvec3 position(vertex.position), above = position + lift_ * glm::dvec3(vertex.normal);
    result.push_back(stage_from_object(Point<Object>{position}).v);
    result.push_back(stage_from_object(Point<Object>{above}).v);
  }
  return result;
}

std::optional<glm::dmat4> PartMotion::then_from_now(const SceneState& then, const SceneState& now) const {
  if (bounds_.same(then.rigs[rig_], now.rigs[rig_]) &&
      then.stage_from_object[instance_] == now.stage_from_object[instance_])
    return {};
  return fitted(points(now), points(then));
}

}  // namespace farshade
