// A viewer's light changes in the scene's state.
#include <gtest/gtest.h>

#include "stereo/scene/scene_state.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

const LightPose kElsewhere{Point<Stage>{{7, 8, 9}}, Vector<Stage>{{0, -1, 0}}};

/// Three lights. The second one moves by one metre per second.
Scene three_lights() {
  Scene scene;
  for (std::uint32_t i = 0; i < 3; ++i) {
    Node node;
    node.rest.translation = {i, 0, 0};
    scene.nodes.push_back(node);
    LightSource light;
    light.node = i;
    light.intensity = glm::vec3(static_cast<float>(i + 1));
    scene.lights.push_back(light);
  }
  scene.channels.push_back({.node = 1, .keys_s = {0, 2}, .values = {{1, 0, 0, 0}, {3, 0, 0, 0}}});
  scene.animation_length_s = 2;
  return scene;
}

TEST(SceneLightChanges, NoneLeaveTheSceneAsItsFileHasIt) {
  const Scene scene = three_lights();
  const SceneState state = state_at(scene, Time{});
  EXPECT_EQ(state.light_set.revision, kFirstLightSet);
  for (const Light& light : state.light_set.lights) EXPECT_TRUE(light.on);
}

TEST(SceneLightChanges, ALightThatIsOffKeepsItsPlaceInTheSet) {
  const Scene scene = three_lights();
  LightChanges changes;
  change(changes, 1, false, std::nullopt);
  const SceneState as_loaded = state_at(scene, Time(500ms)), state = state_at(scene, Time(500ms), changes);
  ASSERT_EQ(state.light_set.lights.size(), 3u);
  EXPECT_EQ(state.light_set.revision, LightSetRevision{2});
  EXPECT_FALSE(state.light_set.lights[1].on);
  EXPECT_EQ(state.light_set.lights[1].position, as_loaded.light_set.lights[1].position);
  EXPECT_EQ(state.light_set.lights[0], as_loaded.light_set.lights[0]);
  EXPECT_EQ(state.light_set.lights[2], as_loaded.light_set.lights[2]);
}

TEST(SceneLightChanges, APoseTakesTheLightOutOfItsAnimation) {
  const Scene scene = three_lights();
  LightChanges changes;
  change(changes, 1, true, kElsewhere);
  for (const Duration at : {0ms, 500ms, 1700ms}) {
    const Light light = state_at(scene, Time(at), changes).light_set.lights[1];
    EXPECT_EQ(light.position, kElsewhere.position);
    EXPECT_EQ(light.direction, kElsewhere.direction);
    EXPECT_EQ(light.intensity, glm::vec3(2.0f));
  }
  change(changes, 1, true, std::nullopt);
  EXPECT_EQ(state_at(scene, Time(500ms), changes).light_set.lights,
            state_at(scene, Time(500ms)).light_set.lights);
}

TEST(SceneLightChanges, OfLightsThatTheSceneDoesNotHaveArePassedOver) {
  const Scene scene = three_lights();
  LightChanges changes;
  for (const std::uint32_t light : {3u, 255u, 0xffffffffu}) change(changes, light, false, kElsewhere);
  const LightSet set = state_at(scene, Time{}, changes).light_set;
  EXPECT_EQ(set.lights, state_at(scene, Time{}).light_set.lights);
  EXPECT_EQ(set.revision, LightSetRevision{4});
}

TEST(SceneLightChanges, AdvanceFollowsThemWhereNothingIsAnimated) {
  Scene scene = three_lights();
  scene.channels.clear();
  scene.animation_length_s = 0;
  SceneState state = state_at(scene, Time{});
  LightChanges first;
  change(first, 0, false, kElsewhere);
  LightChanges other;
  change(other, 2, true, kElsewhere);
  for (const LightChanges& changes : {first, other, LightChanges{}}) {
    advance(scene, Time(1s), changes, state);
    const SceneState fresh = state_at(scene, Time(1s), changes);
    EXPECT_EQ(state.light_set.lights, fresh.light_set.lights);
    EXPECT_EQ(state.light_set.revision, changes.revision);
    EXPECT_EQ(state.light_changes, changes);
  }
}

}  // namespace
}  // namespace farshade
