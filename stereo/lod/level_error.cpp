#include "stereo/lod/level_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace farshade {
namespace {

/// Points on large triangles are at most this part of the mesh's diagonal apart, unless they are too many.
constexpr float kSpacing = 1.0f / 32;
constexpr std::size_t kMostPoints = 4096;
/// Between the samples, a surface may be further away. tests/unit/lod/levels_test.cpp checks the bound at
/// other points.
constexpr float kMargin = 1.4f;
/// Differences that are hard to see: of the normals of a large triangle, and of colours as a part of full
/// brightness. They are properties of the eye: half or twice as much makes levels somewhat finer or coarser.
constexpr float kNormalSlack_rad = 0.2f, kColorSlack = 2.0f / 255;

glm::vec4 color_of(const Mesh& mesh, std::uint32_t vertex) {
  return glm::vec4(mesh.colors[vertex]) * (1.0f / 255);
}

template <class Attribute>
auto interpolated(const glm::uvec3& t, const glm::vec3& weights, const Attribute& attribute) {
  return attribute(t.x) * weights.x + attribute(t.y) * weights.y + attribute(t.z) * weights.z;
}

/// The angle between two lines, at most pi / 2: the nearest point of a thin sheet may lie on its other side.
float angle_between(const glm::vec3& a, const glm::vec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), std::abs(glm::dot(a, b)));
}

float diagonal(std::span<const glm::vec3> points) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const glm::vec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  return glm::length(high - low);
}

/// The distance over which the full mesh's attribute changes by `difference`.
float distance_of(float difference, float gradient) {
  if (difference <= 0) return 0;
  return gradient > 0 ? difference / gradient : std::numeric_limits<float>::infinity();
}

}  // namespace

std::vector<glm::vec3> grid_points(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c,
                                   float spacing) {
  // Rows parallel to the longest edge, which runs from corner `first` to the next one.
  const std::array<float, 3> lengths{glm::length(b - a), glm::length(c - b), glm::length(a - c)};
  const auto first = static_cast<glm::length_t>(std::ranges::max_element(lengths) - lengths.begin());
  const float longest = lengths[static_cast<std::size_t>(first)];
  std::vector<glm::vec3> points;
  if (!(longest > spacing)) return points;
  const float height = glm::length(glm::cross(b - a, c - a)) / longest;
  const auto rows = static_cast<int>(std::ceil(height / spacing)) + 1;
  for (int row = 0; row < rows; ++row) {
    const float up = (static_cast<float>(row) + 0.5f) / static_cast<float>(rows);
    const auto steps = static_cast<int>(std::ceil(longest * (1 - up) / spacing)) + 1;
    for (int step = 0; step < steps; ++step) {
      const float along = (static_cast<float>(step) + 0.5f) / static_cast<float>(steps);
      glm::vec3 weights;
      weights[first] = (1 - up) * (1 - along);
      weights[(first + 1) % 3] = (1 - up) * along;
      weights[(first + 2) % 3] = up;
      points.push_back(weights);
    }
  }
  return points;
}

LevelError::LevelError(const Mesh& mesh, const WeldedMesh& welded, std::span<const glm::vec3> positions)
    : mesh_(mesh),
      welded_(welded),
      positions_(positions),
      full_(positions, welded.triangles),
      used_(positions.size(), true) {
  find_large();
  find_gradients();
}

/// Chooses the spacing and samples the triangles that are larger.
void LevelError::find_large() {
  for (spacing_ = diagonal(positions_) * kSpacing;; spacing_ *= 2) {
    on_large_.clear();
    for (const glm::uvec3& t : welded_.triangles) {
      const glm::vec3 &a = positions_[t.x], &b = positions_[t.y], &c = positions_[t.z];
      const float longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
      const float height = glm::length(glm::cross(b - a, c - a)) / longest;
      for (const glm::vec3& weights : grid_points(a, b, c, spacing_))
        on_large_.push_back({t, weights, height});
      if (on_large_.size() > kMostPoints) break;
    }
    if (on_large_.size() <= kMostPoints) return;
  }
}

void LevelError::find_gradients() {
  gradients_.resize(positions_.size());
  const auto add_edge = [&](std::uint32_t i, std::uint32_t j) {
    const float length = glm::length(positions_[i] - positions_[j]);
    if (!(length > 0)) return;
    const std::uint32_t a = welded_.vertices[i], b = welded_.vertices[j];
    Gradient change;
    if (!mesh_.uvs.empty()) change.uv = glm::length(mesh_.uvs[a] - mesh_.uvs[b]);
    if (!mesh_.colors.empty()) change.color = glm::length(color_of(mesh_, a) - color_of(mesh_, b));
    for (const std::uint32_t vertex : {i, j}) {
      Gradient& most = gradients_[vertex];
      most.uv = std::max(most.uv, change.uv / length);
      most.color = std::max(most.color, change.color / length);
    }
  };
  for (const glm::uvec3& t : welded_.triangles) {
    add_edge(t.x, t.y);
    add_edge(t.y, t.z);
    add_edge(t.z, t.x);
  }
}

glm::vec3 LevelError::position(const Sample& sample) const {
  return interpolated(sample.corners, sample.weights, [&](std::uint32_t i) { return positions_[i]; });
}

/// The angle between a sample's normal and that of the level at the nearest point.
float LevelError::normal_error_rad(const Sample& sample, const NearestPoint& there,
                                   std::span<const glm::uvec3> level) const {
  const auto normal = [&](std::uint32_t i) { return mesh_.normals[welded_.vertices[i]]; };
  return angle_between(interpolated(sample.corners, sample.weights, normal),
                       interpolated(level[there.triangle], there.weights, normal));
}

/// How far the attributes of a sample are from those of the level at the nearest point, as a distance.
float LevelError::attribute_distance(const Sample& sample, const NearestPoint& there,
                                     std::span<const glm::uvec3> level) const {
  const glm::uvec3& t = level[there.triangle];
  Gradient gradient;
  for (const std::uint32_t corner : {sample.corners.x, sample.corners.y, sample.corners.z}) {
    gradient.uv = std::max(gradient.uv, gradients_[corner].uv);
    gradient.color = std::max(gradient.color, gradients_[corner].color);
  }
  const auto difference = [&](const auto& attribute) {
    return glm::length(interpolated(sample.corners, sample.weights, attribute) -
                       interpolated(t, there.weights, attribute));
  };
  // A large triangle with the normals of another surface is shaded wrongly as a whole.
  float distance = normal_error_rad(sample, there, level) > kNormalSlack_rad ? sample.height : 0;
  if (!mesh_.uvs.empty())
    distance = std::max(
        distance, distance_of(difference([&](std::uint32_t i) { return mesh_.uvs[welded_.vertices[i]]; }),
                              gradient.uv));
  if (!mesh_.colors.empty())
    distance = std::max(distance, distance_of(difference([&](std::uint32_t i) {
                                                return color_of(mesh_, welded_.vertices[i]);
                                              }) - kColorSlack,
                                              gradient.color));
  return distance;
}

MeasuredError LevelError::measure(std::span<const glm::uvec3> level, float estimate) {
  const SurfaceDistance coarse(positions_, level);
  float worst = 0, worst_attribute = 0;
  double normal_sum = 0, normals = 0;
  const auto add = [&](const SurfaceDistance& surface, const glm::vec3& p) {
    worst = std::max(worst, surface.distance_above(p, worst, estimate));
  };
  for (const Sample& sample : on_large_) {
    const NearestPoint there = coarse.nearest(position(sample), estimate);
    worst = std::max(worst, there.distance);
    worst_attribute = std::max(worst_attribute, attribute_distance(sample, there, level));
  }
  for (const std::uint32_t vertex : removed_before_) add(coarse, positions_[vertex]);
  std::vector<bool> used(positions_.size(), false);
  for (const glm::uvec3& t : level) used[t.x] = used[t.y] = used[t.z] = true;
  const auto is_new = [&](std::uint32_t vertex) { return used_[vertex] && !used[vertex]; };
  removed_before_.clear();
  for (std::uint32_t vertex = 0; vertex < used.size(); ++vertex) {
    if (!is_new(vertex)) continue;
    removed_before_.push_back(vertex);
    const NearestPoint there = coarse.nearest(positions_[vertex], estimate);
    worst = std::max(worst, there.distance);
    // At a seam the nearest point may lie on the other side.
    if (welded_.on_seam[vertex]) continue;
    const Sample sample{.corners = glm::uvec3(vertex), .weights = {1, 0, 0}};
    worst_attribute = std::max(worst_attribute, attribute_distance(sample, there, level));
    const double angle = normal_error_rad(sample, there, level);
    normal_sum += angle * angle;
    normals += 1;
  }
  // Halfway between vertices, where the level cuts across a ridge or a valley.
  for (const glm::uvec3& t : welded_.triangles)
    for (const auto& [i, j] : {std::pair(t.x, t.y), std::pair(t.y, t.z), std::pair(t.z, t.x)})
      if (i < j && (is_new(i) || is_new(j))) add(coarse, (positions_[i] + positions_[j]) * 0.5f);
  used_ = std::move(used);
  // A vertex that was removed earlier is within the error of that level from vertices that were measured now.
  if (errors_.size() >= 2) worst += errors_[errors_.size() - 2];
  for (const glm::uvec3& t : level) {
    const glm::vec3 &a = positions_[t.x], &b = positions_[t.y], &c = positions_[t.z];
    add(full_, (a + b + c) * (1.0f / 3));
    if (t.x < t.y) add(full_, (a + b) * 0.5f);
    if (t.y < t.z) add(full_, (b + c) * 0.5f);
    if (t.z < t.x) add(full_, (c + a) * 0.5f);
    for (const glm::vec3& weights : grid_points(a, b, c, spacing_))
      add(full_, a * weights.x + b * weights.y + c * weights.z);
  }
  errors_.push_back(worst);
  return {std::max(worst * kMargin, worst_attribute), normals > 0 ? std::sqrt(normal_sum / normals) : 0};
}

}  // namespace farshade
