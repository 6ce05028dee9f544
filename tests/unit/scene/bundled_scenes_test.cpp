/// The bundled scenes have the properties that assets/ORIGIN.md states.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "stereo/gltf/gltf.h"
#include "stereo/scene/scene_state.h"

namespace farshade {
namespace {

Scene bundled(const char* name) {
  auto scene = load_scene(std::string(FARSHADE_ASSETS "/") + name);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().what);
  return scene ? std::move(*scene) : Scene{};
}

TEST(BundledBoxOverPlane, HasItsLightsWhereThePaperSaysSo) {
  const Scene scene = bundled("box_over_plane.gltf");
  const std::vector<Light> lights = state_at(scene, time_from_ns(0)).light_set.lights;
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_EQ(lights[0].kind, LightKind::Point);
  EXPECT_EQ(lights[0].position.v, glm::dvec3(0.25, 4, 0));
  EXPECT_EQ(lights[1].kind, LightKind::Directional);
  EXPECT_LT(glm::length(lights[1].direction.v - glm::normalize(glm::dvec3(1, -1, 0))), 1e-8);
  EXPECT_EQ(scene.triangle_count, 14u);
  EXPECT_TRUE(scene.camera);
}

TEST(BundledRoom, IsAsLargeAndVariedAsPromised) {
  const Scene scene = bundled("room.glb");
  EXPECT_GE(scene.triangle_count, 45'000u);
  EXPECT_LE(scene.triangle_count, 55'000u);
  EXPECT_LE(scene.instances.size(), 80u);
  EXPECT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.animation_length_s, 4.0);
  const auto masked = [](const Material& m) { return m.alpha_cutoff && m.texture; };
  EXPECT_EQ(std::count_if(scene.materials.begin(), scene.materials.end(), masked), 1);
  ASSERT_TRUE(scene.camera);
  EXPECT_LT(glm::length(scene.camera->translation - glm::dvec3(0.95, 1.6, 1.75)), 1e-5);
  EXPECT_NEAR(scene.bounds.low.y, 0.0, 1e-6);
}

TEST(BundledRoom, SwingsOneLightAndTurnsItsPlanets) {
  const Scene scene = bundled("room.glb");
  const SceneState start = state_at(scene, time_from_ns(0)),
                   later = state_at(scene, time_from_ns(1'000'000'000));
  std::set<std::size_t> moved;
  for (std::size_t i = 0; i < start.light_set.lights.size(); ++i)
    if (start.light_set.lights[i] != later.light_set.lights[i]) moved.insert(i);
  EXPECT_EQ(moved, std::set<std::size_t>{1});  // the pendant
  std::size_t instances = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    instances += start.stage_from_object[i] != later.stage_from_object[i] ? 1 : 0;
  EXPECT_EQ(instances, 4u);  // the pendant's shade and three arms of planets
}

TEST(BundledRoom, LoopsWithoutASeam) {
  const Scene scene = bundled("room.glb");
  const SceneState start = state_at(scene, time_from_ns(0)),
                   end = state_at(scene, time_from_ns(3'999'999'000));
  for (std::size_t i = 0; i < start.light_set.lights.size(); ++i)
    EXPECT_LT(length(start.light_set.lights[i].position - end.light_set.lights[i].position), 1e-5);
}

}  // namespace
}  // namespace farshade
