#include "stereo/lod/surface_distance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stereo/lod/weld.h"
#include "tests/unit/lod/shapes.h"

namespace farshade {
namespace {

// The nearest of many points of the triangle is never nearer, and one of them is almost as near.
TEST(SurfaceDistance, FindsTheNearestPointOfATriangle) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(-1, 1);
  const auto point = [&] { return glm::vec3(unit(random), unit(random), unit(random)); };
  for (int trial = 0; trial < 200; ++trial) {
    const glm::vec3 a = point(), b = point(), c = point(), p = 2.0f * point();
    const glm::vec3 weights = nearest_weights(p, a, b, c);
    EXPECT_NEAR(weights.x + weights.y + weights.z, 1, 1e-5);
    EXPECT_GE(std::min({weights.x, weights.y, weights.z}), -1e-6f);
    const float found = glm::length(a * weights.x + b * weights.y + c * weights.z - p);
    float best = 1e9f;
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const float u = static_cast<float>(i) / kSteps, v = static_cast<float>(j) / kSteps;
        best = std::min(best, glm::length(a * (1 - u - v) + b * u + c * v - p));
      }
    EXPECT_LE(found, best + 1e-5f);
    EXPECT_NEAR(found, best, 0.06f);
  }
}

TEST(SurfaceDistance, AgreesWithASearchOverAllTriangles) {
  const Mesh mesh = bumpy_sphere(5);
  const SurfaceDistance surface(mesh.positions, mesh.triangles);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> unit(-2, 2);
  for (int trial = 0; trial < 100; ++trial) {
    const glm::vec3 p(unit(random), unit(random), unit(random));
    float best = 1e9f;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
      const glm::vec3 w = nearest_weights(p, a, b, c);
      best = std::min(best, glm::length(a * w.x + b * w.y + c * w.z - p));
    }
    for (const float guess : {1e-4f, 1.0f, 10.0f}) {
      EXPECT_NEAR(surface.nearest(p, guess).distance, best, 1e-5) << "guess " << guess;
      EXPECT_NEAR(surface.distance_above(p, best * 0.5f, guess), best, 1e-5);
      EXPECT_LE(surface.distance_above(p, best * 1.5f, guess), best * 1.5f);
    }
  }
}

TEST(Weld, JoinsTheFacetsOfASmoothSurface) {
  const Mesh smooth = grid_mesh(
      24, 24, [](float u, float v) { return glm::vec3(u, 0.1f * std::sin(6 * u) * std::cos(5 * v), v); });
  Mesh facets = faceted(smooth);
  const WeldedMesh welded = weld(facets);
  EXPECT_EQ(welded.vertices.size(), smooth.positions.size());
  EXPECT_TRUE(std::ranges::none_of(welded.on_seam, [](bool seam) { return seam; }));
  for (const glm::uvec3& t : welded.triangles) ASSERT_LT(std::max({t.x, t.y, t.z}), welded.vertices.size());
  // Other texture coordinates at the same place are a seam.
  for (std::size_t i = 0; i < facets.positions.size(); ++i) facets.uvs.emplace_back(i < 900 ? 0 : 1, 0);
  const WeldedMesh cut = weld(facets);
  EXPECT_GT(cut.vertices.size(), welded.vertices.size());
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(cut.on_seam, true)),
            2 * (cut.vertices.size() - welded.vertices.size()));
}

TEST(Weld, KeepsHardEdgesApart) {
  Mesh corner;  // three sides of a cube
  corner.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  corner.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
  const WeldedMesh welded = weld(faceted(corner));
  EXPECT_EQ(welded.vertices.size(), 9u);
  EXPECT_TRUE(std::ranges::all_of(welded.on_seam, [](bool seam) { return seam; }));
}

TEST(Weld, RepresentsAGroupByTheNormalClosestToItsMean) {
  Mesh fan;
  for (int i = -2; i <= 2; ++i) {
    const float angle = 0.1f * static_cast<float>(i), next = angle + 0.1f;
    const auto first = static_cast<std::uint32_t>(fan.positions.size());
    fan.positions.insert(fan.positions.end(), {glm::vec3(0), glm::vec3(std::sin(angle), std::cos(angle), 0),
                                               glm::vec3(std::sin(next), std::cos(next), 0)});
    for (int corner = 0; corner < 3; ++corner)
      fan.normals.emplace_back(std::sin(angle), 0.0f, std::cos(angle));
    fan.triangles.emplace_back(first, first + 1, first + 2);
  }
  const WeldedMesh welded = weld(fan);
  const auto centre = std::ranges::find_if(welded.vertices,
                                           [&](std::uint32_t v) { return fan.positions[v] == glm::vec3(0); });
  ASSERT_NE(centre, welded.vertices.end());
  EXPECT_EQ(fan.normals[*centre], glm::vec3(0, 0, 1));
}

}  // namespace
}  // namespace farshade
