// Compares the oracle with results on paper and with its own brute-force search.
#include "tests/oracle/oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

TEST(Oracle, TreeFindsWhatBruteForceFinds) {
  const unsigned seed = 20240607;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-1, 1), size(-0.3f, 0.3f);
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 300; ++i) {
    const glm::vec3 at(place(random), place(random), place(random));
    for (int corner = 0; corner < 3; ++corner)
      corners.push_back(at + glm::vec3(size(random), size(random), size(random)));
  }
  SceneBuilder build;
  build.add(triangle_soup(corners), build.material({}));
  build.add(triangle_soup({{-3, -1, -3}, {3, -1, 3}, {3, -1, -3}}));
  build.point_light({1.5, 2, 0.5});
  build.directional_light({0.2, -1, 0.1});
  const Scene scene = build.build();
  const SceneState state = state_at(scene, Time{});
  const View view = look({0.1, 1.2, 2.4}, {0, 0, 0}, 64);
  const oracle::Masks tree = oracle::trace(scene, state, view, oracle::Search::Tree);
  const oracle::Masks brute = oracle::trace(scene, state, view, oracle::Search::Brute);
  EXPECT_EQ(tree.covered, brute.covered);
  EXPECT_EQ(tree.lit, brute.lit);
  EXPECT_EQ(tree.in_band, brute.in_band);
}

TEST(Oracle, ShadowOfASquareIsWhereSimilarTrianglesPutIt) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.add(quad({0, 1, 0}, {0.5f, 0, 0}, {0, 0, -0.5f}));
  build.point_light({0, 3, 0});  // half sides 0.5 at height 1 become 0.75 at height 0
  const Scene scene = build.build();
  const View below_square = look({0, 0.9, 0.001}, {0, 0, 0}, 100, 2.0);
  const oracle::Masks masks = oracle::trace(scene, state_at(scene, Time{}), below_square);
  const FovTangents window = tangents_of(below_square.fov);
  for (std::uint32_t y = 0; y < 100; ++y)
    for (std::uint32_t x = 0; x < 100; ++x) {
      const glm::dvec3 toward =
          below_square.stage_from_eye(Vector<Eye>{pixel_ray(window, below_square.size, {x + 0.5, y + 0.5})})
              .v;
      const glm::dvec3 point = below_square.stage_from_eye.translation + toward * (-0.9 / toward.y);
      const double from_middle = std::max(std::abs(point.x), std::abs(point.z));
      if (std::abs(from_middle - 0.75) < 1e-9) continue;
      EXPECT_EQ(masks.lit[masks.at(x, y, 0)] != 0, from_middle > 0.75) << x << ", " << y;
    }
}

TEST(Oracle, BandIsTheShadowsEdge) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  // The shadow's edge lies at 1.5 times this x, which is the middle of column 32.
  const float edge = static_cast<float>(0.9 * std::tan(0.5) / 64 / 1.5);
  build.add(quad({2 + edge, 1, 0}, {2, 0, 0}, {0, 0, -4}));
  build.point_light({0, 3, 0});
  const Scene scene = build.build();
  const View view = look({0, 0.9, 0}, {0, 0, -1e-9}, 64, 1.0);
  const oracle::Masks masks = oracle::trace(scene, state_at(scene, Time{}), view);
  for (std::uint32_t x = 0; x < 64; ++x) EXPECT_EQ(masks.in_band[masks.at(x, 30, 0)] != 0, x == 32) << x;
}

}  // namespace
}  // namespace farshade
