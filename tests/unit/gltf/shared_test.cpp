/// Known figures of the scenes that the project was developed with.
#include <gtest/gtest.h>

#include "stereo/gltf/gltf.h"
#include "stereo/scene/scene_state.h"

namespace farshade {
namespace {

Scene shared_scene(const char* name) {
  auto scene = load_scene(std::filesystem::path(FARSHADE_SHARED_SCENES) / name);
  EXPECT_TRUE(scene.has_value()) << scene.error().what;
  return scene ? std::move(*scene) : Scene{};
}

TEST(SharedScenes, LivingRoomHasItsKnownFigures) {
  const Scene scene = shared_scene("modern_living_room.glb");
  EXPECT_EQ(scene.triangle_count, 344416u);
  EXPECT_EQ(scene.meshes.size(), 35u);
  EXPECT_EQ(scene.textures.size(), 2u);
  ASSERT_EQ(scene.lights.size(), 3u);
  for (const LightSource& light : scene.lights) EXPECT_EQ(light.kind, LightKind::Point);
  EXPECT_EQ(state_at(scene, Time{}).light_set.lights[1].position.v, glm::dvec3(-4.9, 2.0, -3.2));
  ASSERT_TRUE(scene.camera.has_value());
  EXPECT_LT(glm::distance(scene.camera->translation, glm::dvec3(0.28, 1.02, -5.19)), 0.01);
  EXPECT_LT(glm::distance(scene.bounds.low, glm::dvec3(-6.0, 0, -6.7)), 0.05);
  EXPECT_LT(glm::distance(scene.bounds.high, glm::dvec3(0.3, 2.7, 0)), 0.05);
  for (const Material& material : scene.materials) EXPECT_TRUE(material.double_sided) << material.name;
}

TEST(SharedScenes, PineTreeHasMaskedLeavesAndASun) {
  const Scene scene = shared_scene("pine_tree.glb");
  EXPECT_EQ(scene.triangle_count, 1652u);
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.lights[0].kind, LightKind::Directional);
  EXPECT_EQ(scene.lights[1].kind, LightKind::Point);
  int masked = 0;
  for (const Material& material : scene.materials) masked += material.alpha_cutoff.has_value();
  EXPECT_EQ(masked, 1);
}

}  // namespace
}  // namespace farshade
