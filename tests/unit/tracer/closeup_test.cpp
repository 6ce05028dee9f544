// Small objects among large ones: where the anchor lies, what is split, and that the tracer agrees with the
// oracle.
#include "stereo/tracer/closeup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/oracle/agreement.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr glm::dvec3 kPlace{700, 20, -300};

/// A box of 5 cm on a floor of 10 km, away from the floor's centre.
Scene box_on_a_huge_floor() {
  SceneBuilder build;
  build.add(quad({0, 20, 0}, {0, 0, 5000}, {5000, 0, 0}));
  NodeTransform placed;
  placed.translation = kPlace;
  build.add(box({0, 0.025f, 0}, glm::vec3(0.025f)), 0, placed);
  build.point_light(kPlace + glm::dvec3(0.3, 0.5, 0.2));
  build.directional_light({0.3, -1, -0.6});
  return build.build();
}

Closeup closeup(const Scene& scene) {
  return closeup_of(scene);
}

std::vector<std::array<Corner, 3>> parts_of(const std::array<glm::dvec3, 3>& triangle, double near_m) {
  const glm::dvec3 up(0, 1, 0);
  std::vector<std::array<Corner, 3>> parts;
  split_graded({Corner{{triangle[0]}, {up}}, {{triangle[1]}, {up}}, {{triangle[2]}, {up}}}, near_m,
               [&](const std::array<Corner, 3>& part) { parts.push_back(part); });
  return parts;
}

glm::dvec3 area(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  return 0.5 * glm::cross(b - a, c - a);
}

/// The corners of parts that lie on the segment, as sorted fractions of its length.
std::vector<double> along(const std::vector<std::array<Corner, 3>>& parts, const glm::dvec3& from,
                          const glm::dvec3& to) {
  std::vector<double> places;
  const glm::dvec3 ray = to - from;
  for (const auto& part : parts)
    for (const Corner& corner : part) {
      const double t = glm::dot(corner.position.v - from, ray) / glm::dot(ray, ray);
      if (glm::length(from + ray * t - corner.position.v) < 1e-9) places.push_back(t);
    }
  std::ranges::sort(places);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

TEST(Closeup, AnchorsOrdinaryScenesAtTheMiddleOfTheirBox) {
  SceneBuilder build({5, 6, 7});
  build.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  build.add(box({3, 0.6f, 0}, glm::vec3(0.3f)));
  const Scene scene = build.build();
  EXPECT_EQ(closeup(scene).anchor.v, (scene.bounds.low + scene.bounds.high) * 0.5);
  EXPECT_EQ(closeup(scene).near_m, std::numeric_limits<double>::infinity());
}

TEST(Closeup, AnchorsLopsidedScenesWhereTheirVerticesAre) {
  const Closeup close = closeup(box_on_a_huge_floor());
  EXPECT_LT(glm::length(close.anchor.v - kPlace), 0.1);
  EXPECT_LT(close.near_m, 2);
}

TEST(SplitGraded, PartsCoverTheTriangleInItsWindingAndNoneIsLong) {
  const std::array<glm::dvec3, 3> triangle{{{-5000, 0.3, -4000}, {-3000, 0.3, 6000}, {7000, 0.3, 100}}};
  const double near_m = 0.5;
  const auto parts = parts_of(triangle, near_m);
  glm::dvec3 sum(0.0);
  for (const auto& part : parts) {
    const glm::dvec3 its = area(part[0].position.v, part[1].position.v, part[2].position.v);
    EXPECT_GT(its.y, 0);
    sum += its;
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3 &a = part[i].position.v, &b = part[(i + 1) % 3].position.v;
      const double nearest = std::min({glm::length(a), glm::length(b), glm::length((a + b) * 0.5)});
      EXPECT_LE(glm::length(b - a), std::max(near_m, nearest) + 1e-9);
    }
  }
  const double whole = area(triangle[0], triangle[1], triangle[2]).y;
  EXPECT_NEAR(sum.y, whole, 1e-9 * whole);
  EXPECT_GT(parts.size(), 50u);
  EXPECT_LT(parts.size(), 1'000u);
}

TEST(SplitGraded, NeighboursShareThePartsOfTheirEdge) {
  const glm::dvec3 a(-5000, 1, -4000), b(6000, 1, 4500), left(-4000, 1, 5000), right(3000, 1, -6000);
  const auto of_left = along(parts_of({a, left, b}, 0.5), a, b),
             of_right = along(parts_of({b, right, a}, 0.5), a, b);
  EXPECT_GT(of_left.size(), 10u);
  EXPECT_EQ(of_left, of_right);
}

TEST(SplitGraded, LeavesWhatIsShortOrFarAsItIs) {
  EXPECT_EQ(parts_of({{{0, 0, 0}, {0.3, 0, 0}, {0, 0, 0.3}}}, 0.5).size(), 1u);
  EXPECT_EQ(parts_of({{{100, 0, 0}, {150, 0, 0}, {100, 0, 50}}}, 0.5).size(), 1u);
}

TEST(TracerPrecision, SmallBoxOnAHugeFloorHasItsWholeShadow) {
  const Scene scene = box_on_a_huge_floor();
  const View view = look(kPlace + glm::dvec3(0.05, 0.25, 0.35), kPlace, 96, 0.6);
  const oracle::Agreement sum = expect_agrees(scene, {view, view}, Time{}, 0.05);
  EXPECT_GT(sum.lit, sum.pixel_lights / 2);
  EXPECT_LT(sum.lit, sum.pixel_lights);
}

}  // namespace
}  // namespace farshade
