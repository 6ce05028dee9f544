#include "stereo/tracer/closeup.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

namespace farshade {
namespace {

constexpr double kLopsided = 256;
/// Edges are never split below this multiple of the median distance from the median vertex.
constexpr double kNear = 16;
constexpr std::size_t kSamples = 4096;

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// About kSamples vertices, every n-th of all.
std::vector<Point<Stage>> sampled(const Scene& scene) {
  const auto places = places_at_start(scene);
  std::size_t count = 0;
  for (const Instance& instance : scene.instances) count += scene.meshes[instance.mesh].positions.size();
  const std::size_t step = count / kSamples + 1;
  std::vector<Point<Stage>> points;
  std::size_t at = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    for (const glm::vec3& p : scene.meshes[scene.instances[i].mesh].positions)
      if (at++ % step == 0) points.push_back(places[i](Point<Object>{glm::dvec3(p)}));
  return points;
}

Point<Stage> median(const std::vector<Point<Stage>>& points) {
  Point<Stage> result;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> along;
    for (const Point<Stage>& p : points) along.push_back(p.v[axis]);
    result.v[axis] = median(std::move(along));
  }
  return result;
}

/// Squared distance of the anchor, which is the origin, from a segment.
double distance2(Point<Anchor> from, Point<Anchor> to) {
  const glm::dvec3 &a = from.v, ab = to.v - from.v;
  const double length2 = glm::dot(ab, ab);
  const double t = length2 > 0 ? std::clamp(-glm::dot(a, ab) / length2, 0.0, 1.0) : 0.0;
  const glm::dvec3 nearest = a + ab * t;
  return glm::dot(nearest, nearest);
}

double length2_of(Point<Anchor> a, Point<Anchor> b) {
  return glm::dot(b.v - a.v, b.v - a.v);
}

bool is_long(Point<Anchor> a, Point<Anchor> b, double near_m) {
  const double length2 = length2_of(a, b);
  return length2 > near_m * near_m && length2 > distance2(a, b);
}

}  // namespace

Closeup closeup_of(const Scene& scene) {
  const Closeup whole{{(scene.bounds.low + scene.bounds.high) * 0.5}};
  const std::vector<Point<Stage>> points = sampled(scene);
  if (points.empty()) return whole;
  const Point<Stage> middle = median(points);
  std::vector<double> away;
  for (const Point<Stage>& p : points) away.push_back(largest((p - middle).v));
  const double typical = median(std::move(away)), half = largest(scene.bounds.high - scene.bounds.low) * 0.5;
  // The file's own float vertices have no detail below a millionth of the whole.
  return typical * kLopsided < half ? Closeup{middle, std::max(kNear * typical, half * 1e-6)} : whole;
}

void split_graded(const std::array<Corner, 3>& triangle, double near_m, const Emit& emit) {
  std::size_t from = 3;
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point<Anchor> a = triangle[i].position, b = triangle[(i + 1) % 3].position;
    const double length2 = length2_of(a, b);
    if (length2 > longest && is_long(a, b, near_m)) longest = length2, from = i;
  }
  if (from == 3) return emit(triangle);
  const Corner &a = triangle[from], &b = triangle[(from + 1) % 3], &c = triangle[(from + 2) % 3];
  const Corner middle{{(a.position.v + b.position.v) * 0.5}, (a.normal + b.normal) * 0.5};
  split_graded({a, middle, c}, near_m, emit);
  split_graded({middle, b, c}, near_m, emit);
}

}  // namespace farshade
