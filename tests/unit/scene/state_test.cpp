/// Instances and lights at a given time, for hierarchies and curves with results computed on paper.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stereo/math/rotation.h"
#include "stereo/scene/moving_bounds.h"
#include "stereo/scene/scene_state.h"
#include "tests/unit/gltf/gltf_builder.h"

namespace farshade {
namespace {

using nlohmann::json;

constexpr Time at(double seconds) {
  return Time(duration_from_ms(seconds * 1e3));
}

/// A scene with one node without a mesh, animated by one channel.
Scene moved_by(Path path, Interpolation interpolation, std::vector<float> keys,
               std::vector<glm::vec4> values) {
  Scene scene;
  scene.nodes.push_back({.name = "mover", .parent = {}, .rest = {}, .moving = true});
  scene.instances.push_back({0, 0});
  scene.animation_length_s = keys.back();
  scene.channels.push_back({0, path, interpolation, std::move(keys), std::move(values)});
  return scene;
}

glm::dvec3 origin_at(const Scene& scene, double seconds) {
  return state_at(scene, at(seconds)).stage_from_object.at(0)(Point<Object>{}).v;
}

TEST(MovingBounds, FollowWhatMovesAndStayWhereNothingDoes) {
  Scene scene =
      moved_by(Path::Translation, Interpolation::Linear, {0, 2}, {glm::vec4(0), glm::vec4(8, 0, -4, 0)});
  scene.meshes.emplace_back().positions = {{-1, -1, -1}, {1, 1, 2}};
  MovingBounds moving(scene);
  EXPECT_EQ(moving.at(Time{}), (Bounds{{-1, -1, -1}, {1, 1, 2}}));
  EXPECT_EQ(moving.at(at(1)), (Bounds{{3, -1, -3}, {5, 1, 0}}));
  scene.nodes.emplace_back();
  scene.instances.push_back({0, 1});  // another one stays
  EXPECT_EQ(MovingBounds(scene).at(at(1)), (Bounds{{-1, -1, -3}, {5, 1, 2}}));
  scene.nodes[0].moving = false;
  scene.bounds = {{-7, -7, -7}, {7, 7, 7}};
  EXPECT_EQ(MovingBounds(scene).at(at(1)), scene.bounds);
}

TEST(SceneState, ComposesHierarchyInDouble) {
  Scene scene;
  Node far{.name = "far", .parent = {}, .rest = {}, .moving = false};
  far.rest.translation = {1e6, 0, 0};
  Node near{.name = "near", .parent = 0u, .rest = {}, .moving = false};
  near.rest.translation = {1e-4, 0, 0};
  scene.nodes = {far, near};
  scene.instances = {{0, 1}};
  EXPECT_NEAR(origin_at(scene, 0).x - 1e6, 1e-4, 1e-9);
}

TEST(SceneState, AppliesScaleThenRotationThenTranslation) {
  Scene scene;
  Node node{.name = "node", .parent = {}, .rest = {}, .moving = false};
  node.rest.translation = {1, 2, 3};
  node.rest.rotation = rotation_exp({0, 0, std::numbers::pi / 2});
  node.rest.scale = {-2, 1, 1};
  scene.nodes = {node};
  scene.instances = {{0, 0}};
  const auto place = state_at(scene, Time{}).stage_from_object.at(0);
  EXPECT_LT(glm::distance(place(Point<Object>{{1, 0, 0}}).v, glm::dvec3(1, 0, 3)), 1e-12);
  EXPECT_LT(glm::determinant(glm::dmat3(place.matrix)), 0.0) << "a mirror stays a mirror";
}

TEST(SceneState, AFlattenedMirrorStaysInvertibleAndAMirror) {
  for (const double scale : {0.0, 1e-12, -0.0, -1e-12, -1.0}) {
    Scene scene;
    Node node{.name = "node", .parent = {}, .rest = {}, .moving = false};
    node.rest.scale = {1, scale, 1};
    scene.nodes = {node};
    scene.instances = {{0, 0}};
    const double determinant =
        glm::determinant(glm::dmat3(state_at(scene, Time{}).stage_from_object.at(0).matrix));
    EXPECT_NE(determinant, 0.0) << scale;
    EXPECT_EQ(std::signbit(determinant), std::signbit(scale)) << scale;
  }
}

/// However large its other axes are.
TEST(SceneState, AFlattenedNodeIsNotSingularButANodeWithoutAnyExtentAcrossIs) {
  const auto state_of = [](const glm::dvec3& outer, const glm::dvec3& inner) {
    Scene scene;
    scene.nodes.emplace_back().rest.scale = outer;
    scene.nodes.emplace_back().rest.scale = inner;
    scene.nodes[1].parent = 0u;
    scene.instances = {{0, 1}};
    return is_singular(glm::dmat3(state_at(scene, Time{}).stage_from_object.at(0).matrix));
  };
  for (const double large : {1e-3, 1.0, 3000.0, 1e8}) {
    EXPECT_FALSE(state_of({1, 1, 1}, {large, 0, large})) << large;
    EXPECT_FALSE(state_of({large, large, large}, {1, -0.0, 1})) << large;
    EXPECT_TRUE(state_of({1, 0, 1}, {1, 1, 0})) << "a line";
  }
  EXPECT_TRUE(is_singular(glm::dmat3(0.0)));
}

TEST(SceneState, UsesMatricesAsTheyAre) {
  GltfBuilder file = triangle_file();
  file.json["nodes"][0]["matrix"] = {2, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1};
  const auto scene = load(file);
  ASSERT_TRUE(scene.has_value());
  const auto place = state_at(*scene, Time{}).stage_from_object.at(0);
  EXPECT_EQ(place(Point<Object>{{1, 2, 0}}).v, glm::dvec3(10, 10, 9));
}

TEST(SceneState, LinearGoesStraightAndRepeats) {
  const Scene scene = moved_by(Path::Translation, Interpolation::Linear, {1, 2, 4},
                               {{0, 0, 0, 0}, {2, 0, 0, 0}, {2, 4, 0, 0}});
  EXPECT_EQ(origin_at(scene, 0.5), glm::dvec3(0, 0, 0)) << "constant before the first key";
  EXPECT_NEAR(origin_at(scene, 1.25).x, 0.5, 1e-9);
  EXPECT_NEAR(origin_at(scene, 3).y, 2.0, 1e-9);
  EXPECT_EQ(origin_at(scene, 4), origin_at(scene, 0));
  EXPECT_NEAR(origin_at(scene, 4 + 3).y, 2.0, 1e-9);
  EXPECT_NEAR(origin_at(scene, -1).y, 2.0, 1e-9) << "negative times repeat as well";
}

TEST(SceneState, StepHoldsUntilTheNextKey) {
  const Scene scene =
      moved_by(Path::Translation, Interpolation::Step, {0, 1, 2}, {{1, 0, 0, 0}, {5, 0, 0, 0}, {9, 0, 0, 0}});
  EXPECT_EQ(origin_at(scene, 0.999).x, 1.0);
  EXPECT_EQ(origin_at(scene, 1).x, 5.0);
}

TEST(SceneState, CubicFollowsItsTangents) {
  // x(t) = t^3 on [0, 2]: value 8 and slope 12 at the end.
  const Scene scene = moved_by(Path::Translation, Interpolation::CubicSpline, {0, 2},
                               {{}, {0, 0, 0, 0}, {0, 0, 0, 0}, {12, 0, 0, 0}, {8, 0, 0, 0}, {}});
  for (const double t : {0.25, 1.0, 1.5}) EXPECT_NEAR(origin_at(scene, t).x, t * t * t, 1e-9);
}

TEST(SceneState, RotationTurnsAtConstantSpeedTheShortWay) {
  const float h = std::sqrt(0.5f);
  const Scene scene = moved_by(Path::Rotation, Interpolation::Linear, {0, 1}, {{0, 0, 0, 1}, {0, -h, 0, -h}});
  const auto place = state_at(scene, at(1.0 / 3)).stage_from_object.at(0);
  const glm::dvec3 x = place(Vector<Object>{{1, 0, 0}}).v;
  EXPECT_NEAR(std::atan2(-x.z, x.x), std::numbers::pi / 6, 1e-6);
}

TEST(SceneState, SplineThroughNoRotationStaysFinite) {
  const Scene scene = moved_by(Path::Rotation, Interpolation::CubicSpline, {0, 1},
                               {{}, {0, 0, 0, 1}, {}, {}, {0, 0, 0, -1}, {}});
  const auto place = state_at(scene, at(0.5)).stage_from_object.at(0);
  EXPECT_NEAR(glm::determinant(glm::dmat3(place.matrix)), 1.0, 1e-9);
}

TEST(SceneState, ScaleThroughZeroCanStillBeInverted) {
  const Scene scene = moved_by(Path::Scale, Interpolation::Linear, {0, 1}, {{1, 1, 1, 0}, {-1, 0, 1, 0}});
  const auto place = state_at(scene, at(0.5)).stage_from_object.at(0);
  EXPECT_NE(glm::determinant(place.matrix), 0.0);
  EXPECT_TRUE(std::isfinite(glm::inverse(place.matrix)[0][0]));
}

TEST(SceneState, LightsFollowTheirNodes) {
  GltfBuilder file = triangle_file();
  const json spot = file.light({{"type", "spot"}, {"range", 3}, {"spot", json::object()}});
  file.node({{"children", {2}}, {"translation", {0, 2, 0}}, {"scale", {2, 2, 2}}});
  file.json["nodes"].push_back({{"extensions", spot},
                                {"translation", {0, 0, -1}},
                                {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}});
  const auto scene = load(file);
  ASSERT_TRUE(scene.has_value()) << scene.error().what;
  const auto set = state_at(*scene, Time{}).light_set;
  ASSERT_EQ(set.lights.size(), 1u);
  EXPECT_LT(glm::distance(set.lights[0].position.v, glm::dvec3(0, 2, -2)), 1e-12);
  EXPECT_LT(glm::distance(set.lights[0].direction.v, glm::dvec3(0, -1, 0)), 1e-7);
  EXPECT_EQ(set.lights[0].range_m, 3.0f);
}

TEST(SceneState, MovingReachesChildrenAndNoOthers) {
  const auto scene = load(rich_file());
  ASSERT_TRUE(scene.has_value());
  for (const Node& node : scene->nodes)
    EXPECT_EQ(node.moving, node.name == "seat" || node.name == "lamp") << node.name;
  EXPECT_EQ(scene->animation_length_s, 2.0);
  const auto lights_at = [&](double s) { return state_at(*scene, at(s)).light_set.lights; };
  EXPECT_NE(lights_at(0)[0].position, lights_at(0.5)[0].position);
  EXPECT_EQ(lights_at(0)[2], lights_at(0.5)[2]);
}

TEST(SceneState, ConstantChannelsAreNoMotion) {
  GltfBuilder file = rich_file();
  const auto still = file.accessor(file.view(std::vector<glm::vec3>(3, {4, 5, 6})), 5126, "VEC3", 3);
  file.json["animations"][0]["samplers"][0]["output"] = still;
  file.json["animations"][0]["channels"].erase(1);
  const auto scene = load(file);
  ASSERT_TRUE(scene.has_value()) << scene.error().what;
  EXPECT_TRUE(scene->channels.empty());
  EXPECT_EQ(scene->animation_length_s, 0.0);
  EXPECT_FALSE(scene->nodes[0].moving);
  EXPECT_EQ(origin_at(*scene, 0.7), glm::dvec3(4, 5, 6));
}

TEST(SceneState, IfAllAnimationsPlayTheFirstOfAPropertyCounts) {
  GltfBuilder file = rich_file();
  const auto once = load(file);
  ASSERT_TRUE(once.has_value()) << once.error().what;
  json again = file.json["animations"][0];
  again["samplers"][0]["output"] =
      file.accessor(file.view(std::vector<glm::vec3>{{7, 7, 7}, {8, 8, 8}, {9, 9, 9}}), 5126, "VEC3", 3);
  again["channels"].erase(1);
  file.json["animations"].push_back(again);
  const auto both = load_scene_from_memory(file.glb(), {}, {}, {.animation = "all"});
  ASSERT_TRUE(both.has_value()) << both.error().what;
  EXPECT_EQ(both->channels.size(), once->channels.size());
  for (const double s : {0.0, 0.7, 1.9}) EXPECT_EQ(origin_at(*both, s), origin_at(*once, s)) << s;
}

TEST(SceneState, AdvanceEqualsStateAt) {
  const auto scene = load(rich_file());
  ASSERT_TRUE(scene.has_value());
  SceneState state = state_at(*scene, Time{});
  for (const double s : {0.3, 1.7, 5.1}) {
    advance(*scene, at(s), {}, state);
    const SceneState fresh = state_at(*scene, at(s));
    EXPECT_EQ(state.scene_time, fresh.scene_time);
    EXPECT_EQ(state.stage_from_object, fresh.stage_from_object);
    EXPECT_EQ(state.light_set.lights, fresh.light_set.lights);
  }
}

}  // namespace
}  // namespace farshade
