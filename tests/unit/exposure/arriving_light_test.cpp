/// The light that arrives at seen points, against results on paper.
#include "stereo/exposure/arriving_light.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

/// A floor at height 0 that is seen from above, and perhaps a roof of 2 m x 2 m at height 2.
SceneBuilder floor_scene(bool roof) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  if (roof) builder.add(quad({0, 2, 0}, {0, 0, 1}, {1, 0, 0}));
  return builder;
}

/// From (x, 1, z) straight down.
Ray down(double x, double z) {
  return {{{x, 1, z}}, {{0, -1, 0}}};
}

ArrivingLight arriving(const Scene& scene, const std::vector<Ray>& rays) {
  const Surroundings surroundings = Surroundings::create(scene).value();
  return {surroundings, scene, seen_points(surroundings, rays)};
}

TEST(SeenPoints, LieOnTheSeenSideOfWhatRaysMeetFirst) {
  const Scene scene = floor_scene(true).build();
  const Surroundings surroundings = Surroundings::create(scene).value();
  const std::vector<Ray> rays{down(0.5, 0), {{{0, 1, 0}}, {{0, 1, 0}}}, {{{0, 1, 0}}, {{1, 0, 0}}}};
  const std::vector<SeenPoint> points = seen_points(surroundings, rays);
  ASSERT_EQ(points.size(), 2u) << "the last ray meets nothing";
  EXPECT_EQ(points[0].instance, 0u);
  EXPECT_EQ(points[1].instance, 1u);
  EXPECT_NEAR(points[0].normal.v.y, 1, 1e-6);
  EXPECT_NEAR(points[1].normal.v.y, -1, 1e-6) << "the roof is seen from below";
  EXPECT_GT(points[0].at.v.y, 0);
  EXPECT_LT(points[1].at.v.y, 2);
  EXPECT_NEAR(points[0].at.v.y, 0, 1e-3);
}

TEST(ArrivingLight, IsThatOfEachKindOfLightOnPaper) {
  SceneBuilder builder = floor_scene(false);
  builder.point_light({0, 2, 0});
  builder.point_light({0, 2, 0}, 4.0f);
  builder.point_light({0, 2, 0}, 1.5f);
  builder.spot_light({0, 2, 0}, {0, -1, 0}, 0.5f);
  builder.directional_light({0, -1, 0});
  builder.directional_light({0, 1, 0});
  const ArrivingLight light = arriving(builder.build(), {down(0, 0), down(2, 0)});
  ASSERT_EQ(light.points().size(), 2u);
  ASSERT_EQ(light.lights(), 6u);
  const auto at = [&](std::size_t point, std::size_t l) { return light.at(point)[l].arriving().g; };
  constexpr float kNear = 1e-3f;
  EXPECT_NEAR(at(0, 0), 1.0f / 4, kNear) << "1 cd in 2 m";
  EXPECT_NEAR(at(1, 0), 1.0f / 8 * std::numbers::sqrt2_v<float> / 2, kNear) << "8 m^2 away, 45 degrees";
  EXPECT_NEAR(at(0, 1), 0.25f * (1 - 1.0f / 16), kNear) << "1 - (2/4)^4";
  EXPECT_EQ(at(0, 2), 0.0f) << "out of range";
  EXPECT_NEAR(at(0, 3), 0.25f, kNear);
  EXPECT_EQ(at(1, 3), 0.0f) << "out of the cone";
  EXPECT_NEAR(at(0, 4), 1, kNear);
  EXPECT_EQ(at(0, 5), 0.0f) << "from below";
  EXPECT_NEAR(light.irradiance(0).g, 0.25f + 0.234f + 0.25f + 1, 2 * kNear);
}

TEST(ArrivingLight, NamesWhatBlocksALight) {
  SceneBuilder builder = floor_scene(true);
  builder.directional_light({0, -1, 0});
  builder.point_light({0, 1.5, 0});
  const ArrivingLight light = arriving(builder.build(), {down(0, 0.5), down(3, 0)});
  ASSERT_EQ(light.points().size(), 2u);
  EXPECT_EQ(light.at(0)[0].blocker, 1u);
  EXPECT_EQ(light.at(0)[0].arriving(), glm::vec3(0.0f));
  EXPECT_EQ(light.at(1)[0].blocker, std::nullopt);
  EXPECT_EQ(light.at(0)[1].blocker, std::nullopt) << "the roof is behind the lamp";
}

TEST(ArrivingLight, UsesAPrefixOfManyPoints) {
  SceneBuilder builder = floor_scene(false);
  for (int i = 0; i < 200; ++i) builder.point_light({0, 2, 0});
  const Scene scene = builder.build();
  const Surroundings surroundings = Surroundings::create(scene).value();
  const ArrivingLight light(surroundings, scene, std::vector<SeenPoint>(2000, {{{0, 1e-3, 0}}, {{0, 1, 0}}}));
  EXPECT_EQ(light.points().size(), ArrivingLight::kMostArrivals / 200);
}

}  // namespace
}  // namespace farshade
