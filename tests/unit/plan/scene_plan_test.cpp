/// The plan leaves out what a scene does not need: one feature at a time.
#include <gtest/gtest.h>

#include "stereo/plan/light_reach.h"
#include "stereo/plan/scene_plan.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

Mesh triangle() {
  return triangle_soup({{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}});
}

Texture checker() {
  return {.image = Image<Rgba8>({2, 2})};
}

/// One untextured, static, double-sided triangle with a point light in front of it.
SceneBuilder simplest() {
  SceneBuilder builder;
  builder.add(triangle());
  builder.point_light({0, 0, 2});
  return builder;
}

TEST(ScenePlan, OfOneStaticTriangleAndOneLightLeavesAllElseOut) {
  const ScenePlan plan = plan_for(simplest().build(), {.two_views = false, .reprojects = false});
  EXPECT_EQ(plan.lights, std::vector{LightStatus::Casts});
  EXPECT_TRUE(plan.server);
  EXPECT_EQ(plan.trace.mask, MaskLayout{1});
  EXPECT_EQ(plan.draw.mask, MaskLayout{1});
  EXPECT_EQ(plan.trace.surfaces, std::vector{SurfaceNeeds{}});
  EXPECT_EQ(plan.draw.surfaces, std::vector{SurfaceNeeds{}});
  EXPECT_EQ(plan.trace.moves, std::vector{false});
  EXPECT_TRUE(plan.trace.skips_rays && plan.trace.shares_views && plan.draw.builds_late);
  EXPECT_FALSE(plan.draw.anything_moves());
  EXPECT_FALSE(plan.draw.ranges_and_cones || plan.draw.other_eye || plan.draw.depth_pass);
}

TEST(ScenePlan, TellsWhatASessionAddsFromWhatASceneAdds) {
  const Scene scene = simplest().build();
  EXPECT_TRUE(plan_for(scene, {.two_views = true}).draw.other_eye);
  EXPECT_FALSE(plan_for(scene, {.two_views = false}).draw.other_eye);
  EXPECT_TRUE(plan_for(scene, {.two_views = false}).draw.depth_pass);
  EXPECT_FALSE(plan_for(scene, {.reprojects = false}).draw.other_eye);
}

TEST(ScenePlan, TurnsOnWhatASurfaceNeedsForThatMeshAlone) {
  SceneBuilder builder = simplest();
  const std::uint32_t texture = builder.texture(checker());
  const std::uint32_t leaf =
      builder.material({.name = "leaf", .texture = texture, .alpha_cutoff = 0.5f, .double_sided = false});
  builder.add(quad({0, 0, -1}, {1, 0, 0}, {0, 1, 0}), leaf);
  Mesh tinted = triangle(), white = triangle();
  tinted.colors.assign(3, glm::u8vec4(255, 0, 0, 255));
  white.colors.assign(3, glm::u8vec4(255));
  builder.add(tinted);
  builder.add(white);
  const std::vector<SurfaceNeeds> expected{
      {}, {.texture = true, .alpha_test = true, .back_test = true}, {.vertex_color = true}, {}};
  EXPECT_EQ(plan_for(builder.build()).draw.surfaces, expected);
  EXPECT_EQ(plan_for(builder.build()).trace.surfaces, expected);
}

TEST(ScenePlan, KnowsWhatMoves) {
  SceneBuilder builder = simplest();
  builder.move(builder.add(triangle()), {1, 0, 0});
  const ScenePlan plan = plan_for(builder.build());
  EXPECT_EQ(plan.trace.moves, (std::vector{false, true}));
  EXPECT_TRUE(plan.draw.anything_moves());
  EXPECT_FALSE(plan.draw.lights_move);

  SceneBuilder lamp = simplest();
  lamp.move(lamp.point_light({0, 0, 3}), {1, 0, 0});
  EXPECT_TRUE(plan_for(lamp.build()).draw.lights_move);
  EXPECT_EQ(plan_for(lamp.build()).trace.moves, std::vector{false});
}

TEST(ScenePlan, LeavesOutLightsThatEndBeforeTheSceneBegins) {
  SceneBuilder builder;
  builder.point_light({0, 0, 9}, 8.0f);
  builder.point_light({0, 0, 7}, 8.0f);
  builder.spot_light({0, 0, 5}, {0.1, 0, 1}, 1.0f);
  builder.spot_light({0, 0, 5}, {0, 0, -1}, 0.1f);
  builder.directional_light({0, 1, 0});
  builder.add(triangle());
  const auto [scene, plan] = plan_scene(builder.build());
  const std::vector expected{LightStatus::OutOfReach, LightStatus::Casts, LightStatus::OutOfReach,
                             LightStatus::Casts, LightStatus::Casts};
  EXPECT_EQ(plan.lights, expected);
  EXPECT_EQ(plan_for(builder.build(), {.all_lights = true}).trace.mask.lights, 5u);
  EXPECT_EQ(plan.trace.mask.lights, 3u);
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(state_at(scene, Time{}).light_set.lights[0].position.v, glm::dvec3(0, 0, 7));
  EXPECT_TRUE(plan.draw.ranges_and_cones);
}

TEST(ScenePlan, KeepsALightThatComesIntoReachOrHasTheSceneComeToIt) {
  SceneBuilder lamp;
  lamp.add(triangle());
  lamp.move(lamp.point_light({0, 0, 9}, 1.0f), {0, 0, -9});
  EXPECT_EQ(plan_for(lamp.build()).lights, std::vector{LightStatus::Casts});
  SceneBuilder guest;
  guest.point_light({0, 0, 9}, 1.0f);
  guest.move(guest.add(triangle()), {0, 0, 9});
  EXPECT_EQ(plan_for(guest.build()).lights, std::vector{LightStatus::Casts});
}

TEST(ScenePlan, KnowsWhatAnimatedLightsBecome) {
  SceneBuilder growing;
  growing.add(triangle());
  growing.point_light({0, 0, 9}, 1.0f);
  growing.change(LightProperty::Range, glm::vec4(1), glm::vec4(10));
  EXPECT_EQ(plan_for(growing.build()).lights, std::vector{LightStatus::Casts});
  EXPECT_TRUE(plan_for(growing.build()).draw.lights_move) << "masks of other times do not fit";
  SceneBuilder short_lived;
  short_lived.add(triangle());
  short_lived.point_light({0, 0, 9}, 1.0f);
  short_lived.change(LightProperty::Range, glm::vec4(1), glm::vec4(2));
  EXPECT_EQ(plan_for(short_lived.build()).lights, std::vector{LightStatus::OutOfReach});
  SceneBuilder flicker = simplest();
  flicker.change(LightProperty::Intensity, glm::vec4(0), glm::vec4(1));
  EXPECT_EQ(plan_for(flicker.build()).lights, std::vector{LightStatus::Casts});
  EXPECT_FALSE(plan_for(flicker.build()).draw.anything_moves()) << "masks fit at all times";
}

TEST(ScenePlan, LeavesOutDarkLightsAndThenTheServer) {
  Scene scene = simplest().build();
  scene.lights[0].intensity = glm::vec3(0);
  const auto [planned, plan] = plan_scene(scene);
  EXPECT_EQ(plan.lights, std::vector{LightStatus::Dark});
  EXPECT_FALSE(plan.server);
  EXPECT_TRUE(planned.lights.empty());
}

TEST(ScenePlan, MakesMaskWordsAsWideAsTheLightsThatCast) {
  for (const auto& [lights, bytes, planes] :
       {std::tuple{8u, 1u, 1u}, {9u, 2u, 1u}, {16u, 2u, 1u}, {17u, 4u, 1u}, {33u, 4u, 2u}}) {
    SceneBuilder builder;
    builder.add(triangle());
    for (std::uint32_t i = 0; i < lights; ++i) builder.point_light({0, 0, 2.0 + i});
    const MaskLayout mask = plan_for(builder.build()).trace.mask;
    EXPECT_EQ(mask.word_bytes(), bytes) << lights;
    EXPECT_EQ(mask.planes(), planes) << lights;
  }
}

TEST(ScenePlan, OfEverythingLeavesNothingOut) {
  SceneBuilder builder = simplest();
  builder.point_light({0, 0, 9}, 1.0f);
  const auto [scene, plan] =
      plan_scene(builder.build(), {.kind = PlanKind::Everything, .two_views = false, .reprojects = false});
  EXPECT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(plan.draw.mask.word_bytes(), 4u);
  EXPECT_EQ(plan.trace.mask.word_bytes(), 4u);
  EXPECT_EQ(plan.draw.surfaces, std::vector(1, SurfaceNeeds{true, true, true, true}));
  EXPECT_EQ(plan.trace.surfaces, plan.draw.surfaces);
  EXPECT_EQ(plan.trace.moves, std::vector{true});
  EXPECT_EQ(plan.draw.moves, std::vector{true});
  EXPECT_FALSE(plan.trace.skips_rays || plan.trace.shares_views || plan.draw.builds_late);
  EXPECT_TRUE(plan.draw.lights_move && plan.draw.ranges_and_cones && plan.draw.other_eye &&
              plan.draw.depth_pass);
}

TEST(ScenePlan, SaysInWordsWhatIsOnAndWhatIsLeftOutAndWhy) {
  SceneBuilder builder = simplest();
  builder.point_light({0, 0, 9}, 1.0f);
  const Scene scene = builder.build();
  const std::string words = in_words(plan_for(scene), scene);
  for (const char* said :
       {"1 of 2 lights cast shadows: 1 byte a pixel", "light 1 left out: it ends before the scene begins",
        "no mesh has one", "no alpha test", "never refitted", "no light has a range or a cone"})
    EXPECT_NE(words.find(said), std::string::npos) << said << " is missing in\n" << words;
  const std::string all = in_words(plan_for(scene, {.kind = PlanKind::Everything}), scene);
  for (const char* said :
       {"everything is on", "2 of 2 lights", "4 bytes a pixel", "one for each covered pixel"})
    EXPECT_NE(all.find(said), std::string::npos) << said << " is missing in\n" << all;
}

TEST(PlanOptions, IsToTellThePlanOrToChooseOne) {
  EXPECT_TRUE(parse_plan_options("").prints_only);
  EXPECT_FALSE(parse_plan_options("everything").prints_only);
  EXPECT_EQ(parse_plan_options("everything").kind, PlanKind::Everything);
  EXPECT_EQ(parse_plan_options("needed").kind, PlanKind::Needed);
}

TEST(LightReach, NeverDeniesALightThatShinesOnARandomPointOfTheBox) {
  std::uint64_t seed = 7;
  const auto random = [&] {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(seed >> 11) / 9007199254740992.0;
  };
  const auto point = [&](double size) { return (glm::dvec3(random(), random(), random()) - 0.5) * size; };
  int denied = 0, shining = 0;
  for (int i = 0; i < 200'000; ++i) {
    const glm::dvec3 a = point(4), b = point(4);
    const Bounds box{glm::min(a, b), glm::max(a, b)};
    Light light;
    light.kind = random() < 0.5 ? LightKind::Point : LightKind::Spot;
    light.position = {point(12)};
    light.direction = {glm::normalize(point(1))};
    light.range_m = static_cast<float>(random() * 8);
    light.outer_cone_rad = static_cast<float>(random() * 1.5);
    const glm::dvec3 p = box.low + (box.high - box.low) * glm::dvec3(random(), random(), random());
    const glm::dvec3 from_light = p - light.position.v;
    const double angle = std::atan2(glm::length(glm::cross(from_light, light.direction.v)),
                                    glm::dot(from_light, light.direction.v));
    const bool shines = glm::length(from_light) < light.range_m &&
                        (light.kind == LightKind::Point || angle < light.outer_cone_rad);
    shining += shines;
    denied += !may_reach(light, box);
    ASSERT_TRUE(!shines || may_reach(light, box)) << "case " << i << " of seed 7";
  }
  EXPECT_GT(denied, 60'000);
  EXPECT_GT(shining, 10'000);
}

}  // namespace
}  // namespace farshade
