/// What files in the wild use beyond the core of glTF 2.0: WebP and other texture formats, instances,
/// variants, animation pointers, and a choice of scenes and cameras. Compressed buffers: compressed_test.cpp.
#include <gtest/gtest.h>

#include "stereo/scene/lighting.h"
#include "stereo/scene/scene_state.h"
#include "tests/unit/gltf/gltf_builder.h"
#include "tests/unit/image/image_files.h"
#include "tests/unit/image/webp_files.h"

namespace farshade {
namespace {

using nlohmann::json;

Scene loaded(const GltfBuilder& file) {
  auto scene = load(file);
  EXPECT_TRUE(scene) << scene.error().what;
  return scene ? *scene : Scene{};
}

Error refused(const GltfBuilder& file) {
  const auto scene = load(file);
  EXPECT_FALSE(scene);
  return scene ? Error{} : scene.error();
}

void expect_says(const std::string& what, const std::string& part) {
  EXPECT_NE(what.find(part), std::string::npos) << what;
}

/// A textured triangle. `texture` is the JSON of its only texture.
GltfBuilder textured_file(const json& texture, const std::vector<std::byte>& image) {
  GltfBuilder file = triangle_file();
  file.json["images"] = {{{"bufferView", file.view(image)}}};
  file.json["textures"] = json::array({texture});  // clang takes {texture} for a copy
  file.json["materials"] = {
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {1, 0.5, 0.25, 1}}, {"baseColorTexture", {{"index", 0}}}}}}};
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  return file;
}

json source_of(const char* extension, int image) {
  return {{"extensions", {{extension, {{"source", image}}}}}};
}

std::vector<std::byte> ktx2_bytes() {
  auto bytes = bytes_of_text("\xabKTX 20\xbb\r\n\x1a\n");
  bytes.resize(80);
  return bytes;
}

TEST(WildTextures, WebpIsDrawn) {
  GltfBuilder file = textured_file(source_of("EXT_texture_webp", 0), make_noise_webp({4, 8}));
  file.json["extensionsRequired"] = file.json["extensionsUsed"] = {"EXT_texture_webp"};
  const Scene scene = loaded(file);
  ASSERT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.textures[0].image.size, (Extent{4, 8}));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(WildTextures, OfBasisUniversalHaveTheirFallbackOrElseTheBaseColour) {
  for (const bool direct : {false, true}) {
    GltfBuilder file = textured_file(
        direct ? json::object({{"source", 0}}) : source_of("KHR_texture_basisu", 0), ktx2_bytes());
    file.json["extensionsRequired"] = {"KHR_texture_basisu"};
    const Scene scene = loaded(file);
    EXPECT_TRUE(scene.textures.empty());
    EXPECT_EQ(scene.materials[0].base_color, glm::vec4(1, 0.5f, 0.25f, 1));
    ASSERT_EQ(scene.warnings.size(), 1u);
    expect_says(scene.warnings[0], "textures without a PNG, JPEG or WebP image are left out");
  }
  GltfBuilder file = textured_file(source_of("KHR_texture_basisu", 0), ktx2_bytes());
  file.json["images"].push_back({{"bufferView", file.view(make_noise_png({4, 4}))}});
  file.json["textures"][0]["source"] = 1;
  const Scene scene = loaded(file);
  EXPECT_EQ(scene.textures.size(), 1u);
  EXPECT_TRUE(scene.warnings.empty());
}

/// A triangle with `extension` as its node's EXT_mesh_gpu_instancing.
GltfBuilder instanced_file(GltfBuilder file, const json& attributes) {
  file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
  file.json["nodes"][0]["translation"] = {0, 10, 0};
  file.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  return file;
}

TEST(WildInstances, BecomeNodesBelowTheirNode) {
  GltfBuilder file = triangle_file();
  const auto places = file.positions({{0, 0, 0}, {5, 0, 0}, {9, 9, 9}});
  const auto turns = file.accessor(file.view<glm::i8vec4>({{0, 0, 0, 127}, {0, 0, 90, 90}, {0, 0, 0, 127}}),
                                   5120, "VEC4", 3, {{"normalized", true}});
  const auto sizes = file.positions({{1, 1, 1}, {2, 2, 2}, {0, 1, 0}});
  file = instanced_file(file, {{"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", sizes}});
  const Scene scene = loaded(file);
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.instances.size(), 2u) << "the third has no size";
  const SceneState state = state_at(scene, Time{});
  const auto place = [&](std::size_t i) { return state.stage_from_object[i](Point<Object>{{1, 0, 0}}).v; };
  EXPECT_LT(glm::length(place(0) - glm::dvec3(1, 10, 0)), 1e-6);
  EXPECT_LT(glm::length(place(1) - glm::dvec3(5, 12, 0)), 1e-6)
      << "scaled, turned to +y, moved, then the node";
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(WildInstances, MoveWithTheirNode) {
  GltfBuilder file = triangle_file();
  const auto places = file.positions({{0, 0, 0}, {5, 0, 0}});
  const auto keys = file.accessor(file.view<float>({0, 1}), 5126, "SCALAR", 2);
  const auto moves = file.positions({{0, 0, 0}, {0, 0, 4}});
  file = instanced_file(file, {{"TRANSLATION", places}});
  file.json["animations"] = {
      {{"samplers", {{{"input", keys}, {"output", moves}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
  const Scene scene = loaded(file);
  const SceneState state = state_at(scene, time_from_ns(500'000'000));
  EXPECT_LT(glm::length(state.stage_from_object[1](Point<Object>{{0, 0, 0}}).v - glm::dvec3(5, 0, 2)), 1e-6);
}

TEST(WildInstances, MorphTargetsFollowTheWeightsOfTheirNode) {
  GltfBuilder file = triangle_file();
  const auto places = file.positions({{0, 0, 0}, {5, 0, 0}});
  const auto keys = file.accessor(file.view<float>({0, 1}), 5126, "SCALAR", 2);
  const auto weights = file.accessor(file.view<float>({0, 1}), 5126, "SCALAR", 2);
  const auto target = file.positions({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}});
  file.json["meshes"][0]["primitives"][0]["targets"] = json::array({{{"POSITION", target}}});
  file = instanced_file(file, {{"TRANSLATION", places}});
  file.json["animations"] = {
      {{"samplers", {{{"input", keys}, {"output", weights}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  const Scene scene = loaded(file);
  EXPECT_TRUE(scene.warnings.empty());
  ASSERT_EQ(scene.rigs.size(), 2u) << "one for each instance";
  for (const RigPose& pose : state_at(scene, time_from_ns(500'000'000)).rigs)
    EXPECT_EQ(pose.weights, std::vector<float>{0.5f});
}

TEST(WildInstances, RefusesMoreWeightsThanASmallFileShouldHave) {
  GltfBuilder file = triangle_file();
  file.json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 60'000}});
  std::vector<float> times(100);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = static_cast<float>(i);
  const auto keys = file.accessor(file.view(times), 5126, "SCALAR", 100);
  file = instanced_file(file, {{"TRANSLATION", 2}});
  file.json["animations"] = {
      {{"samplers", {{{"input", keys}, {"output", keys}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  const Error error = refused(file);
  EXPECT_EQ(error.fault, Fault::OutOfRange);
  expect_says(error.what, "more keys than a file of this size should have");
}

TEST(WildInstances, WhoseAttributesDoNotFitShowTheMeshOnce) {
  GltfBuilder file = triangle_file();
  const auto two = file.positions({{0, 0, 0}, {5, 0, 0}}),
             three = file.positions({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  expect_says(outcome_of(load(instanced_file(file, {{"TRANSLATION", two}, {"SCALE", three}}))),
              "node 0 'seat': instance accessor 3 has 3 elements for 2 instances; its mesh is drawn once");
  expect_says(outcome_of(load(instanced_file(file, {{"ROTATION", two}}))),
              "has a type that this attribute cannot have");
  expect_says(outcome_of(load(instanced_file(file, {{"TRANSLATION", 99}}))), "accessor 99 is not there");
  EXPECT_EQ(loaded(instanced_file(file, {{"TRANSLATION", 99}})).instances.size(), 1u);
}

TEST(WildInstances, RefusesMoreThanASmallFileShouldHave) {
  GltfBuilder file = triangle_file();
  file.json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 1 << 17}});
  const Error error = refused(instanced_file(file, {{"TRANSLATION", 2}}));
  EXPECT_EQ(error.fault, Fault::OutOfRange);
  expect_says(error.what, "131072 instances are more than a file of this size should have");
}

GltfBuilder pointer_file(const char* pointer) {
  GltfBuilder file = triangle_file();
  const auto keys = file.accessor(file.view<float>({0, 1}), 5126, "SCALAR", 2);
  const auto moves = file.positions({{0, 0, 0}, {0, 0, 4}});
  file.json["extensionsUsed"] = {"KHR_animation_pointer"};
  file.json["animations"] = {
      {{"samplers", {{{"input", keys}, {"output", moves}}}},
       {"channels",
        {{{"sampler", 0},
          {"target",
           {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}}}}}};
  return file;
}

TEST(WildAnimationPointers, ToNodesMoveThem) {
  const Scene scene = loaded(pointer_file("/nodes/0/translation"));
  EXPECT_TRUE(scene.warnings.empty());
  const SceneState state = state_at(scene, time_from_ns(500'000'000));
  EXPECT_LT(glm::length(state.stage_from_object[0](Point<Object>{{0, 0, 0}}).v - glm::dvec3(0, 0, 2)), 1e-6);
}

TEST(WildAnimationPointers, ToOtherThingsStandStillWithAWarning) {
  for (const char* pointer : {"/materials/0/emissiveFactor", "/nodes/0/mesh", "/nodes/x/scale",
                              "/nodes//scale", "/nodes/99999999999/scale", "", "/nodes/"}) {
    const Scene scene = loaded(pointer_file(pointer));
    EXPECT_EQ(scene.animation_length_s, 0) << pointer;
    ASSERT_EQ(scene.warnings.size(), 1u) << pointer;
    expect_says(scene.warnings[0], "KHR_animation_pointer: only nodes and lights are animated");
  }
  expect_says(outcome_of(load(pointer_file("/nodes/7/translation"))), "there is no node 7");
  expect_says(outcome_of(load(pointer_file("/nodes/3000000000/translation"))), "there is no node 2147483647");
}

TEST(WildMaterials, WithoutLightAndThatGlowAreDrawnLitWithAWarning) {
  GltfBuilder file = triangle_file();
  file.json["extensionsUsed"] = {"KHR_materials_emissive_strength", "KHR_materials_unlit",
                                 "KHR_materials_variants"};
  const Scene scene = loaded(file);
  ASSERT_EQ(scene.warnings.size(), 1u);
  expect_says(scene.warnings[0], "materials without light are lit");
  EXPECT_FALSE(scene.materials.at(0).unlit);
  file.json["materials"] = {{{"extensions", {{"KHR_materials_unlit", json::object()}}}}};
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  EXPECT_TRUE(loaded(file).materials.at(0).unlit);
}

TEST(WildMaterials, OfSpecularAndGlossinessHaveTheirDiffuseColour) {
  GltfBuilder file = textured_file({{"source", 0}}, make_noise_png({4, 4}));
  json& material = file.json["materials"][0];
  material = {{"extensions",
               {{"KHR_materials_pbrSpecularGlossiness",
                 {{"diffuseFactor", {0.5, 0.25, 0, 1}}, {"diffuseTexture", {{"index", 0}}}}}}}};
  const Scene scene = loaded(file);
  EXPECT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.materials[0].base_color, glm::vec4(0.5f, 0.25f, 0, 1));
}

/// Two scenes, each with a camera, and a triangle with two variants of its material.
GltfBuilder choice_file() {
  GltfBuilder file = triangle_file();
  file.json["cameras"] = {{{"name", "lens"}, {"type", "perspective"}}, {{"type", "perspective"}}};
  file.node({{"name", "front"}, {"camera", 0}, {"translation", {0, 0, 5}}});
  file.node({{"name", "camera:back"}, {"translation", {0, 0, -5}}});
  file.json["nodes"].push_back({{"name", "far seat"}, {"mesh", 0}, {"translation", {100, 0, 0}}});
  file.json["scenes"][0]["name"] = "day";
  file.json["scenes"].push_back({{"name", "night"}, {"nodes", {3}}});
  file.json["materials"] = {{{"name", "red"}}, {{"name", "green"}}};
  json& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["material"] = 0;
  primitive["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {1}}}};
  file.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "beach"}}, {{"name", "meadow"}}};
  file.json["extensionsRequired"] = {"KHR_materials_variants"};
  return file;
}

Expected<Scene> chosen(const SceneChoice& choice) {
  return load_scene_from_memory(choice_file().glb(), {}, {}, choice);
}

TEST(SceneChoices, TheFilesOwnIsTheDefault) {
  const Scene scene = chosen({}).value();
  EXPECT_EQ(scene.nodes.size(), 3u);
  EXPECT_EQ(scene.camera->translation, glm::dvec3(0, 0, -5));
  EXPECT_EQ(scene.materials[scene.meshes[0].material].name, "red");
  EXPECT_EQ(scene.contents.scenes, (std::vector<std::string>{"day", "night"}));
  EXPECT_EQ(scene.contents.cameras, (std::vector<std::string>{"front", "camera:back"}));
  EXPECT_EQ(scene.contents.variants, (std::vector<std::string>{"beach", "meadow"}));
}

TEST(SceneChoices, ChangeTheSceneAndItsHash) {
  const SceneHash hash = chosen({})->hash;
  const Scene night = chosen({.scene = 1}).value();
  EXPECT_EQ(night.nodes[0].name, "far seat");
  EXPECT_FALSE(night.camera);
  EXPECT_EQ(night.contents.scene, 1u);
  EXPECT_NE(night.hash, hash);
  for (const char* name : {"front", "lens"}) {
    const Scene scene = chosen({.camera = name}).value();
    EXPECT_EQ(scene.camera->translation, glm::dvec3(0, 0, 5)) << name;
    EXPECT_NE(scene.hash, hash);
  }
  EXPECT_EQ(chosen({.camera = "back"})->hash, hash) << "it is the reference camera";
  const Scene meadow = chosen({.variant = "meadow"}).value();
  EXPECT_EQ(meadow.materials[meadow.meshes[0].material].name, "green");
  const Scene beach = chosen({.variant = "beach"}).value();
  EXPECT_EQ(beach.materials[beach.meshes[0].material].name, "red") << "no mapping: the primitive's own";
}

TEST(SceneChoices, RefuseWhatIsNotThereWithAListOfWhatIs) {
  EXPECT_EQ(chosen({.scene = 2}).error().what, "there is no scene 2; the file has 0 'day', 1 'night'");
  EXPECT_EQ(chosen({.camera = "top"}).error().what,
            "there is no camera 'top'; the scene has 'front', 'camera:back'");
  EXPECT_EQ(chosen({.scene = 1, .camera = "front"}).error().what,
            "there is no camera 'front'; the scene has none");
  EXPECT_EQ(chosen({.variant = "x"}).error().what, "there is no variant 'x'; the file has 'beach', 'meadow'");
}

/// Three animations of one node; the second has no name, and the third one is called like a word.
GltfBuilder clips_file() {
  GltfBuilder file = triangle_file();
  const auto keys = file.accessor(file.view<float>({0, 2}), 5126, "SCALAR", 2);
  for (const float x : {1.0f, 2.0f, 3.0f}) {
    const auto places = file.accessor(file.view<float>({0, 0, 0, x, 0, 0}), 5126, "VEC3", 2);
    file.json["animations"].push_back(
        {{"samplers", {{{"input", keys}, {"output", places}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
  }
  file.json["animations"][0]["name"] = "run";
  file.json["animations"][2]["name"] = "jump";
  return file;
}

TEST(SceneChoices, OneAnimationPlays) {
  const auto where = [](const GltfBuilder& file, const std::string& name) {
    const Scene scene = load_scene_from_memory(file.glb(), {}, {}, {.animation = name}).value();
    return state_at(scene, Time(duration_from_ms(1000))).stage_from_object[0].matrix[3].x;
  };
  GltfBuilder file = clips_file();
  EXPECT_EQ(where(file, ""), 0.5);
  EXPECT_EQ(where(file, "run"), 0.5);
  EXPECT_EQ(where(file, "animation 1"), 1.0);
  EXPECT_EQ(where(file, "jump"), 1.5);
  EXPECT_EQ(where(file, "all"), 0.5) << "the first one counts";
  EXPECT_EQ(where(file, "none"), 0.0);
  file.json["animations"][2]["name"] = "none";
  EXPECT_EQ(where(file, "none"), 1.5) << "a name of the file comes first";
}

TEST(SceneChoices, ListAnimationsAndSayWhichOnePlays) {
  const Scene first = load(clips_file()).value();
  EXPECT_EQ(first.contents.animations, (std::vector<std::string>{"run", "animation 1", "jump"}));
  EXPECT_EQ(first.warnings, std::vector<std::string>{"of 3 animations, 'run' plays (--animation NAME, all or "
                                                     "none): 'run', 'animation 1', 'jump'"});
  for (const char* name : {"run", "all", "none"}) {
    const auto scene = load_scene_from_memory(clips_file().glb(), {}, {}, {.animation = name});
    EXPECT_TRUE(scene->warnings.empty()) << name;
    EXPECT_EQ(scene->contents.animations.size(), 3u) << name;
  }
  EXPECT_EQ(load_scene_from_memory(clips_file().glb(), {}, {}, {.animation = "walk"}).error().what,
            "there is no animation 'walk'; the file has 'run', 'animation 1', 'jump'");
  EXPECT_EQ(load_scene_from_memory(triangle_file().glb(), {}, {}, {.animation = "walk"}).error().what,
            "there is no animation 'walk'; the file has none");
  EXPECT_TRUE(load_scene_from_memory(triangle_file().glb(), {}, {}, {.animation = "none"}));
}

TEST(SceneChoices, CountVariantsWithoutAName) {
  GltfBuilder file = choice_file();
  file.json["extensions"]["KHR_materials_variants"]["variants"][0] = json::object();
  const auto scene = load_scene_from_memory(file.glb(), {}, {}, {.variant = "meadow"});
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->materials[scene->meshes[0].material].name, "green");
}

TEST(SceneChoices, ReachASceneThatIsLit) {
  EXPECT_EQ(light_scene(chosen({.scene = 1}).value(), {})->scene.nodes[0].name, "far seat");
}

TEST(SceneChoices, OfAVariantOfAMaterialThatIsNotThereHaveTheDefaultMaterial) {
  GltfBuilder file = choice_file();
  file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] =
      9;
  EXPECT_EQ(outcome_of(load(file)), "drawn") << "the default does not use it";
  const auto scene = load_scene_from_memory(file.glb(), {}, {}, {.variant = "meadow"});
  expect_says(outcome_of(scene), "there is no material 9; it has the default material");
}

TEST(WildMembers, ThatNobodyReadsMayHaveAnyType) {
  const SceneHash hash = loaded(rich_file()).hash;
  GltfBuilder file = rich_file();
  file.json["extras"] = {1, nullptr, "x", {{"deep", {{}}}}};
  file.json["cameras"] = {{{"type", 7}, {"perspective", "wide"}}};
  file.json["accessors"][0]["min"] = "low";
  file.json["materials"][0]["emissiveFactor"] = {1};
  file.json["materials"][0]["normalTexture"] = -1;
  file.json["meshes"][0]["primitives"][0]["targets"] = json::array();
  file.json["nodes"][0]["extensions"]["EXT_nobody_knows"] = 3;
  file.json["samplers"][0]["minFilter"] = "sharp";
  const auto scene = load(file);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->hash, hash);
}

/// tinygltf ends names at a zero byte.
TEST(WildMembers, WhoseNamesHaveAZeroByteAreNotThoseBeforeIt) {
  GltfBuilder file = rich_file();
  const SceneHash hash = loaded(file).hash;
  auto& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
  attributes[std::string("NORMAL\0", 7)] = 99;
  attributes[std::string("POSITION\0x", 10)] = 98;
  EXPECT_EQ(loaded(file).hash, hash);
}

TEST(WildAnimations, LeaveOutChannelsWithoutANode) {
  GltfBuilder file = rich_file();
  const std::size_t all = loaded(file).channels.size();
  ASSERT_GE(all, 1u);
  file.json["animations"][0]["channels"][0]["target"].erase("node");
  EXPECT_EQ(loaded(file).channels.size(), all - 1);
}

TEST(WildMembers, OfExtensionsMayBeLargeWholeNumbers) {
  const auto uvs = [](const json& offset) {
    GltfBuilder file = rich_file();
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]
             ["KHR_texture_transform"] = {{"offset", offset}};
    return loaded(file).meshes.at(0).uvs;
  };
  EXPECT_EQ(uvs({3000000000u, 1}), uvs({3e9, 1.0}));
  EXPECT_EQ(uvs({3000000000u, 1}).at(0).x, 3e9f);
}

/// Bytes of a fallback buffer do not exist, so nothing may read them.
TEST(WildBuffers, OfAFallbackBufferAreNotRead) {
  GltfBuilder file = triangle_file();
  file.json["buffers"].push_back(
      {{"byteLength", 36}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  EXPECT_TRUE(load(file)) << "nothing reads it";
  file.json["bufferViews"][0]["buffer"] = 1;
  expect_says(refused(file).what, "reads beyond its buffer (0 bytes)");
}

TEST(WildIndices, MayBeSparseWithoutABufferView) {
  GltfBuilder file = triangle_file();
  const auto numbers = file.view<std::uint8_t>({1, 2, 0, 0}), values = file.view<std::uint16_t>({1, 2});
  file.json["accessors"].push_back({{"componentType", 5123},
                                    {"type", "SCALAR"},
                                    {"count", 3},
                                    {"sparse",
                                     {{"count", 2},
                                      {"indices", {{"bufferView", numbers}, {"componentType", 5121}}},
                                      {"values", {{"bufferView", values}}}}}});
  file.json["meshes"][0]["primitives"][0]["indices"] = file.json["accessors"].size() - 1;
  EXPECT_EQ(loaded(file).meshes.at(0).triangles.at(0), glm::uvec3(0, 1, 2));
}

TEST(WildIndices, Of8And16BitsAreRead) {
  for (const int component : {5121, 5123, 5125}) {
    GltfBuilder file;
    const auto positions = file.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
    const auto view = component == 5121   ? file.view<std::uint8_t>({2, 1, 3})
                      : component == 5123 ? file.view<std::uint16_t>({2, 1, 3})
                                          : file.view<std::uint32_t>({2, 1, 3});
    file.mesh({{"attributes", {{"POSITION", positions}}},
               {"indices", file.accessor(view, component, "SCALAR", 3)}});
    const Scene scene = loaded(file);
    EXPECT_EQ(scene.meshes[0].positions[2], glm::vec3(1, 1, 0)) << component;
  }
}

TEST(WildIndices, OfStripsAndFansAreRead) {
  for (const int mode : {5, 6}) {
    GltfBuilder file;
    const auto positions = file.positions({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
    const auto order =
        mode == 5 ? std::vector<std::uint8_t>{0, 1, 3, 2} : std::vector<std::uint8_t>{0, 1, 2, 3};
    file.mesh({{"attributes", {{"POSITION", positions}}},
               {"indices", file.accessor(file.view(order), 5121, "SCALAR", 4)},
               {"mode", mode}});
    const Scene scene = loaded(file);
    EXPECT_EQ(scene.triangle_count, 2u);
    for (const glm::vec3 normal : scene.meshes[0].normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1)) << mode;
  }
}

TEST(WildInstances, AreFlatWhereOneScaleIs0) {
  GltfBuilder file = triangle_file();
  file = instanced_file(file, {{"SCALE", file.positions({{1, 1, 0}, {0, 1, 0}})}});
  EXPECT_EQ(loaded(file).instances.size(), 1u);
}

TEST(WildNodes, MayBeNestedDeeplyWithOrWithoutMatrices) {
  GltfBuilder file = triangle_file();
  std::uint32_t inner = file.node({{"mesh", 0}});
  for (int i = 0; i < 80; ++i) {
    inner = file.node({{"children", {inner}}, {"rotation", {0.6, 0, 0, 0.8}}});
    inner = file.node(
        {{"children", {inner}}, {"matrix", {0.8, 0.6, 0, 0, -0.6, 0.8, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
  }
  file.json["scenes"][0]["nodes"] = {inner};
  const Scene scene = loaded(file);
  EXPECT_EQ(scene.instances.size(), 1u);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(WildNodes, MayBeAnywhereIfNoSceneHasThem) {
  GltfBuilder file = triangle_file();
  file.node({{"translation", {1e13, 0, 0}}});
  file.json["scenes"][0]["nodes"] = {0};
  EXPECT_EQ(loaded(file).instances.size(), 1u);
  file.json["scenes"][0]["nodes"] = {0, 1};
  expect_says(refused(file).what, "reaches further than 1e12 m");
}

TEST(WildNodes, AreFlatWhereTheMatrixFlattensAlongOneAxis) {
  for (const bool along_two : {false, true}) {
    GltfBuilder file = triangle_file();
    const int x = along_two ? 0 : 1;
    file.json["nodes"].push_back({{"mesh", 0}, {"matrix", {x, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 5, 0, 0, 1}}});
    file.json["scenes"][0]["nodes"] = {0, 1};
    const Scene scene = loaded(file);
    ASSERT_EQ(scene.instances.size(), along_two ? 1u : 2u);
    EXPECT_TRUE(scene.warnings.empty());
    if (along_two) continue;
    const glm::dmat4 placed = state_at(scene, Time{}).stage_from_object[1].matrix;
    EXPECT_FALSE(is_singular(glm::dmat3(placed)));
    EXPECT_LT(glm::length(placed[2]), 1e-8);
  }
}

TEST(WildNodes, HaveNamesOf256BytesAtMost) {
  GltfBuilder file = triangle_file();
  std::string name = "a";
  for (int i = 0; i < 300; ++i) name += "\xc3\xa4";
  file.json["nodes"][0]["name"] = name;
  EXPECT_EQ(loaded(file).nodes[0].name, name.substr(0, 255)) << "without half a character";
}

TEST(WildSkins, NeedJointsAndWeights) {
  for (const char* lacks : {"JOINTS_0", "WEIGHTS_0"}) {
    GltfBuilder file = triangle_file();
    json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = file.accessor(file.view(std::vector<std::uint8_t>(12, 0)), 5121, "VEC4", 3);
    attributes["WEIGHTS_0"] =
        file.accessor(file.view<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}), 5126, "VEC4", 3);
    attributes.erase(lacks);
    const auto joint = file.node({{"translation", {100, 0, 0}}});
    file.json["skins"] = {{{"joints", {joint}}}};
    file.json["nodes"][0]["skin"] = 0;
    const Scene scene = loaded(file);
    ASSERT_EQ(scene.warnings.size(), 1u);
    expect_says(scene.warnings[0], ": its mesh has no joints and weights for its skin");
    EXPECT_LT(scene.bounds.high.x, 50) << "it stands where its node is";
  }
}

TEST(WildVersions, OfTwoAreReadHoweverTheyAreWritten) {
  GltfBuilder file = triangle_file();
  file.json["asset"] = {{"version", "2"}, {"minVersion", "1.0"}};
  EXPECT_TRUE(loaded(file).warnings.empty());
  file.json["asset"] = {{"version", 2.0}};
  EXPECT_FALSE(loaded(file).warnings.empty());
  file.json["asset"] = {{"version", "2.0"}, {"minVersion", "2.1"}};
  expect_says(refused(file).what, "glTF version 2.1, only 2.0 is read");
  file.json["asset"] = {{"version", 1.1}};
  expect_says(refused(file).what, "glTF version 1.0, only 2.0 is read");
}

/// The unknown extension is found though the list has something that is no text.
TEST(WildExtensions, AreRequiredAlsoInAListWithFaults) {
  GltfBuilder file = triangle_file();
  file.json["extensionsRequired"] = {"FOO_bar", 5};
  expect_says(refused(file).what, "the required extension 'FOO_bar' is not supported");
  file.json["extensionsRequired"] = {"KHR_materials_sheen"};
  const Scene scene = loaded(file);
  ASSERT_EQ(scene.warnings.size(), 1u) << "also if extensionsUsed does not name it";
  expect_says(scene.warnings[0], "KHR_materials_sheen is not drawn");
}

}  // namespace
}  // namespace farshade
