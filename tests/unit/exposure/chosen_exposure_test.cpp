/// The exposure that is chosen for scenes whose lights have any unit.
#include "stereo/exposure/chosen_exposure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "stereo/scene/scene_hash.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

/// A room of 6 m x 3 m x 6 m, whose camera is in its middle. The walls are seen from both sides.
SceneBuilder room() {
  SceneBuilder builder;
  Material both;
  both.double_sided = true;
  builder.add(box({0, 1.5f, 0}, {3, 1.5f, 3}), builder.material(both));
  return builder;
}

Scene finished(const SceneBuilder& builder) {
  Scene scene = builder.build();
  scene.camera = Rigid<Stage, Eye>{{1, 0, 0, 0}, {0, 1.5, 0}};
  return scene;
}

Scene with_last_light(SceneBuilder builder, float intensity) {
  Scene scene = finished(builder);
  scene.lights.back().intensity = glm::vec3(intensity);
  return scene;
}

SceneBuilder lamp_room() {
  SceneBuilder builder = room();
  builder.point_light({0, 2.5, 0});
  return builder;
}

TEST(ChosenExposure, IsNoneWhereTheSceneIsNeitherDarkNorWhite) {
  for (const float candela : {1.0f, 3.0f, 8.0f})
    EXPECT_EQ(chosen_exposure(with_last_light(lamp_room(), candela)), Exposure{}) << candela;
  EXPECT_EQ(chosen_exposure(finished(room())), Exposure{}) << "no light";
}

/// It does not change while the lights do.
TEST(ChosenExposure, IsForLightsAtTheirBrightest) {
  SceneBuilder builder = lamp_room();
  builder.change(LightProperty::Intensity, glm::vec4(0), glm::vec4(1000));
  EXPECT_EQ(chosen_exposure(finished(builder)), chosen_exposure(with_last_light(lamp_room(), 1000)));
}

/// Twice the light is four quarter stops less.
TEST(ChosenExposure, FollowsTheLightInQuarterStops) {
  const int at_100 = chosen_exposure(with_last_light(lamp_room(), 100)).quarter_stops;
  EXPECT_LT(at_100, 0);
  EXPECT_EQ(chosen_exposure(with_last_light(lamp_room(), 200)).quarter_stops, at_100 - 4);
  EXPECT_EQ(chosen_exposure(with_last_light(lamp_room(), 100 * std::exp2(0.25f))).quarter_stops, at_100 - 1);
  EXPECT_EQ(chosen_exposure(with_last_light(lamp_room(), 102400)).quarter_stops, at_100 - 40);
  EXPECT_GT(chosen_exposure(with_last_light(lamp_room(), 1e-3f)).quarter_stops, 0);
  EXPECT_EQ(chosen_exposure(with_last_light(lamp_room(), 1e30f)).quarter_stops, -Exposure::kMostQuarterStops);
  EXPECT_EQ(chosen_exposure(with_last_light(lamp_room(), 1e-30f)).quarter_stops, Exposure::kMostQuarterStops);
  EXPECT_NEAR(Exposure{4}.factor(), 2, 1e-6);
  EXPECT_NEAR(Exposure{-2}.factor(), std::sqrt(0.5), 1e-6);
}

TEST(ChosenExposure, CountsTheLightThatArrivesAndNotTheSunOutside) {
  SceneBuilder builder = lamp_room();
  builder.directional_light({0.3, -1, 0.2});
  EXPECT_EQ(chosen_exposure(with_last_light(builder, 100'000)), Exposure{}) << "the roof is closed";
  SceneBuilder open;
  open.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  open.directional_light({0.3, -1, 0.2});
  EXPECT_NEAR(chosen_exposure(with_last_light(open, 100'000)).factor(), 0.4 * 3.14159 / 94'000, 2e-6);
}

/// A spot of sun on the floor is no reason to make the room black.
TEST(ChosenExposure, IsThatOfTheMedianPoint) {
  SceneBuilder builder;
  Material both;
  both.double_sided = true;
  const std::uint32_t walls = builder.material(both);
  builder.add(quad({0, 0, 0}, {0, 0, 3}, {3, 0, 0}), walls);
  for (const float side : {-1.0f, 1.0f}) {
    builder.add(quad({0, 1.5f, 3 * side}, {3, 0, 0}, {0, 1.5f, 0}), walls);
    builder.add(quad({3 * side, 1.5f, 0}, {0, 0, 3}, {0, 1.5f, 0}), walls);
    builder.add(quad({1.7f * side, 3, 0}, {1.3f, 0, 0}, {0, 0, 3}), walls);  // a gap of 0.8 m
  }
  builder.point_light({0, 2.5, 0});
  builder.directional_light({0, -1, 0});
  Scene scene = with_last_light(builder, 100'000);
  scene.lights[0].intensity = glm::vec3(4.0f);
  EXPECT_EQ(chosen_exposure(scene), Exposure{});
}

TEST(ChosenExposure, SeesThingsThatLookSmall) {
  SceneBuilder builder;
  builder.add(box({0, 0, 0}, {0.05f, 0.05f, 0.05f}));
  builder.directional_light({0.5, -1, -0.7});
  Scene scene = with_last_light(builder, 1000);
  scene.camera->translation = {0, 0, 30};
  EXPECT_LT(chosen_exposure(scene).quarter_stops, -20);
}

TEST(ChosenExposure, IsNotPartOfTheHash) {
  const Scene dark = with_last_light(lamp_room(), 1e-3f);
  EXPECT_EQ(hash_of(dark), hash_of(with_last_light(lamp_room(), 1e-3f)));
  EXPECT_EQ(in_words(Exposure{}, "a.glb"), "");
  EXPECT_EQ(in_words(Exposure{-8}, "a.glb"),
            "a.glb would be too bright: all lights are multiplied by 0.25 (--exposure sets another factor)");
}

}  // namespace
}  // namespace farshade
