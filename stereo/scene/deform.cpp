#include "stereo/scene/deform.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "stereo/base/check.h"

namespace farshade {
namespace {

glm::vec3 unit_or(const glm::vec3& v, const glm::vec3& otherwise) {
  const float length = glm::length(v);
  return length > 0 && length < std::numeric_limits<float>::infinity() ? v / length : otherwise;
}

/// Turns a normal by a blended transform. One that flattens space keeps the normal's direction.
glm::vec3 turned(const glm::mat3& m, const glm::vec3& normal) {
  const glm::mat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  const glm::vec3 result = cofactors * normal;
  return unit_or(glm::dot(m[0], cofactors[0]) < 0 ? -result : result, normal);
}

/// The box around a box that is transformed, and the rounding of float sums that lead there.
Bounds moved_in_floats(const glm::dmat4& transform, const Bounds& box) {
  constexpr double kRounding = 1e-6;
  const glm::dvec3 far = glm::max(glm::abs(box.low), glm::abs(box.high));
  glm::dvec3 terms = glm::abs(glm::dvec3(transform[3]));
  for (int column = 0; column < 3; ++column) terms += far[column] * glm::abs(glm::dvec3(transform[column]));
  const Bounds result = moved(transform, box);
  return {result.low - kRounding * terms, result.high + kRounding * terms};
}

/// False for NaN. Files can bind vertices so that an animation moves them out of what float can compute with.
bool is_near(const glm::vec3& p) {
  constexpr float kMaxDistance_m = 1e12f;
  return std::abs(p.x) <= kMaxDistance_m && std::abs(p.y) <= kMaxDistance_m &&
         std::abs(p.z) <= kMaxDistance_m;
}

}  // namespace

Deformation::Deformation(const Deformable& deformable, const RigPose& pose)
    : deformable_(deformable), pose_(pose) {
  for (std::size_t i = 0; i < std::min(deformable.targets.size(), pose.weights.size()); ++i)
    if (pose.weights[i] != 0) active_.push_back({&deformable.targets[i], pose.weights[i]});
}

DeformedVertex Deformation::morphed(std::size_t index) const {
  const bool flat = deformable_.normals.empty();
  DeformedVertex result{deformable_.positions[index], flat ? glm::vec3(0.0f) : deformable_.normals[index]};
  for (const auto& [target, weight] : active_) {
    if (!target->positions.empty()) result.position += weight * target->positions[index];
    if (!flat && !target->normals.empty()) result.normal += weight * target->normals[index];
  }
  if (!flat && !active_.empty()) result.normal = unit_or(result.normal, deformable_.normals[index]);
  return result;
}

DeformedVertex Deformation::blended(std::size_t index) const {
  DeformedVertex result = morphed(index);
  if (deformable_.influences.empty()) return result;
  const auto& [joints, weights] = deformable_.influences[index];
  glm::mat4 transform = pose_.object_from_bind[joints[0]] * weights[0];
  for (int i = 1; i < 4; ++i)
    if (weights[i] != 0) transform += pose_.object_from_bind[joints[i]] * weights[i];
  result.position = glm::vec3(transform * glm::vec4(result.position, 1.0f));
  if (!deformable_.normals.empty()) result.normal = turned(glm::mat3(transform), result.normal);
  return result;
}

DeformedVertex Deformation::skinned(std::size_t index) const {
  DeformedVertex result = blended(index);
  if (!is_near(result.position)) result.position = glm::vec3(0.0f);
  return result;
}

glm::vec3 Deformation::facet_normal(std::size_t index) const {
  const std::size_t first = index / 3 * 3;
  const glm::vec3 a = skinned(first).position;
  return unit_or(glm::cross(skinned(first + 1).position - a, skinned(first + 2).position - a),
                 glm::vec3(0, 1, 0));
}

DeformedVertex Deformation::vertex(std::size_t index) const {
  DeformedVertex result = skinned(index);
  if (deformable_.normals.empty()) result.normal = facet_normal(index);
  return result;
}

void Deformation::write(std::span<glm::vec3> positions, std::span<glm::vec3> normals) const {
  check_eq(positions.size(), deformable_.positions.size(), "a place for every vertex");
  check_eq(normals.size(), positions.size(), "a normal for every vertex");
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const DeformedVertex vertex = skinned(i);
    positions[i] = vertex.position, normals[i] = vertex.normal;
  }
  if (!deformable_.normals.empty()) return;
  for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
    const glm::vec3 normal = unit_or(
        glm::cross(positions[i + 1] - positions[i], positions[i + 2] - positions[i]), glm::vec3(0, 1, 0));
    std::ranges::fill(normals.subspan(i, 3), normal);
  }
}

DeformBounds::DeformBounds(const Deformable& deformable) : all_(bounds_of(deformable.positions)) {
  for (const Deformable::Target& target : deformable.targets) targets_.push_back(bounds_of(target.positions));
  for (std::size_t v = 0; v < deformable.influences.size(); ++v)
    for (int i = 0; i < 4; ++i) {
      if (deformable.influences[v].weights[i] == 0) continue;
      const std::uint16_t joint = deformable.influences[v].joints[i];
      auto found = std::ranges::find(joints_, joint, &JointBox::joint);
      if (found == joints_.end()) found = joints_.insert(found, {joint, kNoPoint});
      const glm::dvec3 p(deformable.positions[v]);
      found->box = joined(found->box, {p, p});
    }
}

Bounds DeformBounds::at(const RigPose& pose) const {
  Bounds grown{glm::dvec3(0.0), glm::dvec3(0.0)};  // by morph targets
  for (std::size_t i = 0; i < std::min(targets_.size(), pose.weights.size()); ++i) {
    const double weight = pose.weights[i];
    const glm::dvec3 a = targets_[i].low * weight, b = targets_[i].high * weight;
    grown.low += glm::min(a, b), grown.high += glm::max(a, b);
  }
  const auto with = [&](const Bounds& box) { return Bounds{box.low + grown.low, box.high + grown.high}; };
  Bounds result = joints_.empty() ? moved_in_floats(glm::dmat4(1.0), with(all_)) : kNoPoint;
  for (const auto& [joint, box] : joints_)
    result = joined(result, moved_in_floats(glm::dmat4(pose.object_from_bind[joint]), with(box)));
  // Vertices beyond that are at the origin.
  const glm::dvec3 farthest(1e12);
  const glm::dvec3 low = glm::clamp(result.low, -farthest, farthest),
                   high = glm::clamp(result.high, -farthest, farthest);
  if (result == Bounds{low, high}) return result;
  return joined({low, high}, {glm::dvec3(0.0), glm::dvec3(0.0)});
}

bool DeformBounds::same(const RigPose& a, const RigPose& b) const {
  for (std::size_t i = 0; i < std::min(targets_.size(), a.weights.size()); ++i)
    if (a.weights[i] != b.weights[i] && targets_[i] != Bounds{}) return false;
  return std::ranges::all_of(joints_, [&](const JointBox& of) {
    return a.object_from_bind[of.joint] == b.object_from_bind[of.joint];
  });
}

}  // namespace farshade
