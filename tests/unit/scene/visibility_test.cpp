/// KHR_node_visibility: what it hides, at rest and animated.
#include <gtest/gtest.h>

#include <cmath>

#include "stereo/scene/scene_hash.h"
#include "stereo/scene/scene_state.h"
#include "tests/unit/gltf/gltf_builder.h"

namespace farshade {
namespace {

using nlohmann::json;

json visible(bool is_visible) {
  return {{"KHR_node_visibility", {{"visible", is_visible}}}};
}

/// A visible triangle, and below `group` another one and a lamp.
GltfBuilder group_file(const json& group) {
  GltfBuilder file = triangle_file();
  const auto lamp = file.node({{"extensions", file.light({{"type", "point"}, {"intensity", 5}})}});
  const auto shown = file.node({{"mesh", 0}});
  json inner = {{"children", {lamp, shown}}};
  const auto middle = file.node(inner);
  json outer = group;
  outer["children"] = {middle};
  const auto root = file.node(outer);
  file.json["scenes"][0]["nodes"] = {0, root};
  file.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_node_visibility"};
  return file;
}

/// Animates the visibility of a node: hidden between 1 s and 2 s, and the animation lasts 3 s.
void blink(GltfBuilder& file, std::uint32_t node, const char* interpolation = "STEP", int component = 5121) {
  const auto keys = file.accessor(file.view<float>({0, 1, 2, 3}), 5126, "SCALAR", 4);
  const auto values = component == 5121
                          ? file.accessor(file.view<std::uint8_t>({1, 0, 255, 1}), 5121, "SCALAR", 4)
                          : file.accessor(file.view<float>({1, 0, 1, 1}), component, "SCALAR", 4);
  const std::string pointer = "/nodes/" + std::to_string(node) + "/extensions/KHR_node_visibility/visible";
  file.json["animations"] = {
      {{"samplers", {{{"input", keys}, {"output", values}, {"interpolation", interpolation}}}},
       {"channels",
        {{{"sampler", 0},
          {"target",
           {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}}}}}};
  file.json["extensionsUsed"].push_back("KHR_animation_pointer");
}

Scene loaded(const GltfBuilder& file) {
  auto scene = load(file);
  EXPECT_TRUE(scene) << scene.error().what;
  return scene ? *scene : Scene{};
}

bool is_there(const Scene& scene, std::size_t instance, double seconds) {
  const SceneState state = state_at(scene, Time(duration_from_ms(seconds * 1e3)));
  return !is_singular(glm::dmat3(state.stage_from_object.at(instance).matrix));
}

float intensity(const Scene& scene, double seconds) {
  return state_at(scene, Time(duration_from_ms(seconds * 1e3))).light_set.lights.at(0).intensity.x;
}

TEST(NodeVisibility, HidesMeshesAndLightsOfTheNodesBelow) {
  const Scene scene = loaded(group_file({{"extensions", visible(false)}}));
  EXPECT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.triangle_count, 1u);
  EXPECT_TRUE(scene.lights.empty());
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(NodeVisibility, TrueChangesNothing) {
  const Scene plain = loaded(group_file(json::object()));
  EXPECT_EQ(plain.instances.size(), 2u);
  EXPECT_EQ(plain.lights.size(), 1u);
  EXPECT_EQ(loaded(group_file({{"extensions", visible(true)}})).hash, plain.hash);
  EXPECT_EQ(loaded(group_file({{"extensions", {{"KHR_node_visibility", json::object()}}}})).hash, plain.hash);
}

TEST(NodeVisibility, AnAnimationHidesAndShowsWhatIsBelow) {
  for (const bool at_rest : {true, false}) {
    GltfBuilder file = group_file({{"extensions", visible(at_rest)}});
    blink(file, 4);
    const Scene scene = loaded(file);
    ASSERT_EQ(scene.instances.size(), 2u);
    EXPECT_EQ(scene.animation_length_s, 3);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_FALSE(can_move(scene, scene.instances[0]));
    EXPECT_TRUE(can_move(scene, scene.instances[1])) << "the tracer builds it anew";
    for (const double seconds : {0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.5, 4.5}) {
      const bool shown = std::fmod(seconds, 3.0) < 1 || std::fmod(seconds, 3.0) >= 2;
      EXPECT_TRUE(is_there(scene, 0, seconds)) << seconds;
      EXPECT_EQ(is_there(scene, 1, seconds), shown) << seconds;
      EXPECT_EQ(intensity(scene, seconds), shown ? 5.0f : 0.0f) << seconds;
    }
  }
}

TEST(NodeVisibility, TheBoundsHoldWhatIsHiddenAtFirst) {
  const json aside = {{"translation", {5, 0, 0}}};
  GltfBuilder file = group_file(aside);
  blink(file, 4);
  file.json["animations"][0]["samplers"][0]["output"] =
      file.accessor(file.view<std::uint8_t>({0, 1, 1, 1}), 5121, "SCALAR", 4);
  const Scene scene = loaded(file);
  EXPECT_FALSE(is_there(scene, 1, 0));
  EXPECT_EQ(scene.bounds, loaded(group_file(aside)).bounds);
}

TEST(NodeVisibility, BelowAHiddenNodeAnAnimationShowsNothing) {
  GltfBuilder file = group_file({{"extensions", visible(false)}});
  blink(file, 3);
  EXPECT_EQ(loaded(file).instances.size(), 1u);
}

TEST(NodeVisibility, AConstantAnimationCountsAsTheNodesOwn) {
  GltfBuilder file = group_file({{"extensions", visible(true)}});
  blink(file, 4);
  const auto zeros = file.accessor(file.view<std::uint8_t>({0, 0, 0, 0}), 5121, "SCALAR", 4);
  file.json["animations"][0]["samplers"][0]["output"] = zeros;
  const Scene scene = loaded(file);
  EXPECT_EQ(scene.instances.size(), 1u);
  EXPECT_TRUE(scene.lights.empty());
}

TEST(NodeVisibility, IsPartOfTheHash) {
  GltfBuilder first = group_file(json::object()), second = group_file(json::object());
  blink(first, 4), blink(second, 3);
  const Scene scene = loaded(first);
  EXPECT_NE(scene.hash, loaded(second).hash);
  for (const bool light : {false, true}) {
    Scene changed = scene;
    if (light)
      changed.lights[0].hides = false;
    else
      changed.instances[1].shown_with.reset();
    EXPECT_NE(hash_of(changed), scene.hash) << light;
  }
}

/// A skinned mesh is hidden with its own node, not with its joints.
TEST(NodeVisibility, HidesASkinnedMeshWithItsNode) {
  for (const bool moves : {false, true}) {
    GltfBuilder file = triangle_file();
    json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = file.accessor(file.view(std::vector<std::uint8_t>(12, 0)), 5121, "VEC4", 3);
    attributes["WEIGHTS_0"] =
        file.accessor(file.view<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}), 5126, "VEC4", 3);
    const auto joint = file.node({{"extensions", visible(false)}});
    file.json["skins"] = {{{"joints", {joint}}}};
    file.json["nodes"][0]["skin"] = 0;
    file.node({{"mesh", file.json["meshes"].size()}});
    file.json["meshes"].push_back(triangle_file().json["meshes"][0]);
    blink(file, 0);
    if (moves) {
      json& animation = file.json["animations"][0];
      const auto places =
          file.accessor(file.view<float>({0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0}), 5126, "VEC3", 4);
      animation["samplers"].push_back({{"input", animation["samplers"][0]["input"]}, {"output", places}});
      animation["channels"].push_back(
          {{"sampler", 1}, {"target", {{"node", joint}, {"path", "translation"}}}});
    }
    const Scene scene = loaded(file);
    ASSERT_EQ(scene.instances.size(), 2u);
    EXPECT_EQ(scene.instances[0].rig.has_value(), moves);
    EXPECT_TRUE(is_there(scene, 0, 0.5));
    EXPECT_FALSE(is_there(scene, 0, 1.5));
    EXPECT_TRUE(is_there(scene, 1, 1.5));
  }
}

TEST(NodeVisibility, OtherNumbersAndInterpolationsAreReadAsSteps) {
  for (const auto& [interpolation, component] :
       {std::pair("LINEAR", 5121), {"CUBICSPLINE", 5121}, {"STEP", 5126}}) {
    GltfBuilder file = group_file(json::object());
    blink(file, 4, interpolation, component);
    const Scene scene = loaded(file);
    EXPECT_TRUE(is_there(scene, 1, 0.9)) << interpolation << " " << component;
    EXPECT_FALSE(is_there(scene, 1, 1.9)) << interpolation << " " << component;
  }
}

TEST(NodeVisibility, StaysAsItIsIfThereAreNotAsManyValuesAsKeys) {
  GltfBuilder file = group_file(json::object());
  blink(file, 4);
  file.json["animations"][0]["samplers"][0]["output"] =
      file.accessor(file.view<std::uint8_t>({1, 0, 1}), 5121, "SCALAR", 3);
  const Scene scene = loaded(file);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("has 3 elements, should have 4"), std::string::npos) << scene.warnings[0];
  EXPECT_TRUE(is_there(scene, 1, 1.5));
}

}  // namespace
}  // namespace farshade
