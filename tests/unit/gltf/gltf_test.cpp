/// The supported features, on files whose result is known on paper.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "stereo/frame/eye_mask.h"
#include "stereo/scene/scene_state.h"
#include "tests/unit/gltf/gltf_builder.h"
#include "tests/unit/image/image_files.h"

namespace farshade {
namespace {

using nlohmann::json;
using Triangle = std::array<glm::vec3, 3>;

Scene loaded(const GltfBuilder& file) {
  auto scene = load(file);
  EXPECT_TRUE(scene.has_value()) << scene.error().what;
  return scene ? std::move(*scene) : Scene{};
}

std::vector<Triangle> triangles_of(const Mesh& mesh) {
  std::vector<Triangle> result;
  for (const glm::uvec3 t : mesh.triangles)
    result.push_back({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
  return result;
}

const glm::vec3 kA{0, 0, 0}, kB{1, 0, 0}, kC{0, 1, 0}, kD{1, 1, 0}, kE{0, 2, 0};

Scene with_mode(int mode, const std::vector<glm::vec3>& points) {
  GltfBuilder file;
  file.mesh({{"attributes", {{"POSITION", file.positions(points)}}}, {"mode", mode}});
  return loaded(file);
}

TEST(GltfMesh, ReadsTextAndBinaryAlike) {
  const auto text = triangle_file().gltf();
  const auto from_text = load_copy(text.data(), text.size());
  ASSERT_TRUE(from_text.has_value()) << from_text.error().what;
  const Scene from_glb = loaded(triangle_file());
  EXPECT_EQ(from_text->hash, from_glb.hash);
  EXPECT_EQ(triangles_of(from_glb.meshes.at(0)), (std::vector<Triangle>{{kA, kB, kC}}));
}

TEST(GltfMesh, ReadsTrianglesWithoutIndices) {
  EXPECT_EQ(triangles_of(with_mode(4, {kA, kB, kC, kB, kD, kC}).meshes.at(0)),
            (std::vector<Triangle>{{kA, kB, kC}, {kB, kD, kC}}));
}

TEST(GltfMesh, StripsKeepTheirWinding) {
  const Scene scene = with_mode(5, {kA, kB, kC, kD, kE});
  EXPECT_EQ(triangles_of(scene.meshes.at(0)),
            (std::vector<Triangle>{{kA, kB, kC}, {kB, kD, kC}, {kC, kD, kE}}));
  for (const glm::vec3 normal : scene.meshes[0].normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
}

TEST(GltfMesh, FansKeepTheirWinding) {
  const Scene scene = with_mode(6, {kA, kB, kD, kC});
  EXPECT_EQ(triangles_of(scene.meshes.at(0)), (std::vector<Triangle>{{kB, kD, kA}, {kD, kC, kA}}));
}

TEST(GltfMesh, LeavesOutLinesPointsAndTrianglesWithoutArea) {
  GltfBuilder file;
  const auto points = file.positions({kA, kB, kC, kA, kB, kB, kA, kC, kE});
  file.mesh({{"attributes", {{"POSITION", points}}}});
  file.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", points}}}, {"mode", 1}});
  file.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", points}}}, {"mode", 0}});
  const Scene scene = loaded(file);
  EXPECT_EQ(scene.triangle_count, 1u);
  EXPECT_EQ(scene.meshes.size(), 1u);
}

TEST(GltfMesh, MissingNormalsAreTheFaces) {
  GltfBuilder file;
  const auto points = file.positions({kA, kB, kC, {0, 0, 1}});
  const auto indices = file.accessor(file.view<std::uint8_t>({0, 1, 2, 0, 2, 3}), 5121, "SCALAR", 6);
  file.mesh({{"attributes", {{"POSITION", points}}}, {"indices", indices}});
  const Mesh mesh = loaded(file).meshes.at(0);
  ASSERT_EQ(mesh.normals.size(), 6u) << "triangles share no vertices";
  EXPECT_EQ(mesh.normals[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(mesh.normals[5], glm::vec3(1, 0, 0));
  EXPECT_EQ(triangles_of(mesh), (std::vector<Triangle>{{kA, kB, kC}, {kA, kC, {0, 0, 1}}}));
}

TEST(GltfMesh, NormalsBecomeUnitAndZeroOnesFollowTheTriangles) {
  GltfBuilder file = triangle_file();
  file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      file.accessor(file.view<glm::vec3>({{0, 3, 0}, {0, 0, 0}, {0, 0, 1}}), 5126, "VEC3", 3);
  EXPECT_EQ(loaded(file).meshes.at(0).normals, (std::vector<glm::vec3>{{0, 1, 0}, {0, 0, 1}, {0, 0, 1}}));
}

TEST(GltfMesh, UndoesQuantization) {
  GltfBuilder file;
  file.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  // Elements of six bytes at a distance of eight bytes, as the specification requires.
  const auto positions = file.view<std::int16_t>({-32768, 32767, 0, 0, 0, 0, 0, 0, 32767, 0, 0, 0});
  file.json["bufferViews"][positions]["byteStride"] = 8;
  const auto normals = file.view<std::int8_t>({0, 0, 127, 0, 0, 0, 127, 0, 0, 0, -128, 0});
  file.json["bufferViews"][normals]["byteStride"] = 4;
  file.mesh({{"attributes",
              {{"POSITION", file.accessor(positions, 5122, "VEC3", 3, {{"normalized", true}})},
               {"NORMAL", file.accessor(normals, 5120, "VEC3", 3, {{"normalized", true}})}}}});
  const Mesh mesh = loaded(file).meshes.at(0);
  EXPECT_EQ(mesh.positions, (std::vector<glm::vec3>{{-1, 1, 0}, {0, 0, 0}, {1, 0, 0}}));
  EXPECT_EQ(mesh.normals, (std::vector<glm::vec3>{{0, 0, 1}, {0, 0, 1}, {0, 0, -1}}));
}

TEST(GltfMesh, AppliesSparseElements) {
  const Mesh mesh = loaded(rich_file()).meshes.at(0);
  EXPECT_EQ(mesh.positions, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5f}, {0, 1, 0}}));
}

TEST(GltfMesh, SparseElementsWithoutBufferReplaceZeros) {
  GltfBuilder file = rich_file();
  file.json["accessors"][0].erase("bufferView");
  file.json["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", file.positions({kA, kB, kC})}}}});
  const Scene scene = loaded(file);
  EXPECT_EQ(scene.meshes.size(), 1u) << "all but one vertex at 0: the mesh has no area";
}

TEST(GltfMesh, ReadsVertexColours) {
  GltfBuilder file = triangle_file();
  file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] =
      file.accessor(file.view<glm::vec3>({{0, 0.5f, 1}, {2, -1, 0}, {1, 1, 1}}), 5126, "VEC3", 3);
  const auto colors = loaded(file).meshes.at(0).colors;
  EXPECT_EQ(colors, (std::vector<glm::u8vec4>{{0, 128, 255, 255}, {255, 0, 0, 255}, {255, 255, 255, 255}}));
}

TEST(GltfMesh, AppliesTheTextureTransform) {
  GltfBuilder file = rich_file();
  auto& transform = file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]
                             ["KHR_texture_transform"];
  transform = {{"offset", {0.5, 0.25}}, {"rotation", std::numbers::pi / 2}, {"scale", {2, 3}}};
  // A quarter turn counter-clockwise in the image, with v down: (u, v) -> (v, -u).
  const auto uvs = loaded(file).meshes.at(0).uvs;
  const std::vector<glm::vec2> expected = {{0.5, 0.25}, {0.5, -1.75}, {3.5, -1.75}, {3.5, 0.25}};
  ASSERT_EQ(uvs.size(), expected.size());
  for (std::size_t i = 0; i < uvs.size(); ++i) EXPECT_LT(glm::distance(uvs[i], expected[i]), 1e-6f) << i;
}

TEST(GltfMesh, ReadsTheCoordinateSetThatTheMaterialNames) {
  GltfBuilder file = rich_file();
  const auto second =
      file.accessor(file.view<glm::u8vec4>({{0, 255, 0, 0}, {0, 0, 0, 0}, {51, 0, 0, 0}, {0, 0, 0, 0}}), 5121,
                    "VEC2", 4, {{"normalized", true}});
  file.json["bufferViews"].back()["byteStride"] = 4;
  file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = second;
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index", 0}, {"extensions", {{"KHR_texture_transform", {{"texCoord", 1}}}}}};
  EXPECT_EQ(loaded(file).meshes.at(0).uvs, (std::vector<glm::vec2>{{0, 1}, {0, 0}, {0.2f, 0}, {0, 0}}));
}

TEST(GltfMaterial, ReadsFactorsWrapsAndSides) {
  GltfBuilder file = rich_file();
  file.json["materials"][0]["doubleSided"] = true;
  file.json["materials"][0]["alphaCutoff"] = 0.25;
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.1, 0.2, 0.3, 0.4};
  const Scene scene = loaded(file);
  const Material& material = scene.materials.at(0);
  EXPECT_EQ(material.name, "cloth");
  EXPECT_EQ(material.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(material.alpha_cutoff, 0.25f);
  EXPECT_TRUE(material.double_sided);
  const Texture& texture = scene.textures.at(material.texture.value());
  EXPECT_EQ(texture.image.size, (Extent{4, 4}));
  EXPECT_EQ(texture.wrap_u, Wrap::ClampToEdge);
  EXPECT_EQ(texture.wrap_v, Wrap::MirroredRepeat);
}

TEST(GltfMaterial, BlendIsMaskAtAHalf) {
  GltfBuilder file = rich_file();
  file.json["materials"][0]["alphaMode"] = "BLEND";
  EXPECT_EQ(loaded(file).materials.at(0).alpha_cutoff, 0.5f);
}

TEST(GltfMaterial, DropsTheAlphaTestWhereNothingIsAHole) {
  GltfBuilder file = rich_file();
  file.json["images"][0] = {{"bufferView", file.view(make_jpeg({4, 4}, JpegKind::Colour))}};
  EXPECT_FALSE(loaded(file).materials.at(0).alpha_cutoff.has_value());
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0.4};
  EXPECT_TRUE(loaded(file).materials.at(0).alpha_cutoff.has_value());
}

TEST(GltfMaterial, MissingMaterialIsWhiteAndOneSided) {
  const Scene scene = loaded(triangle_file());
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].base_color, glm::vec4(1.0f));
  EXPECT_FALSE(scene.materials[0].double_sided);
  EXPECT_FALSE(scene.materials[0].texture.has_value());
}

TEST(GltfMaterial, UnusedDamagedImagesAreNotDecoded) {
  GltfBuilder file = rich_file();
  file.json["images"].push_back({{"bufferView", 0}});
  file.json["textures"].push_back({{"source", 1}});
  EXPECT_EQ(loaded(file).textures.size(), 1u);
}

TEST(GltfNodes, ParentsComeFirstAndOtherScenesDoNotCount) {
  GltfBuilder file = triangle_file();
  file.json["nodes"] = {{{"name", "leaf"}, {"mesh", 0}, {"translation", {0, 0, 1}}},
                        {{"name", "other"}, {"mesh", 0}},
                        {{"name", "root"}, {"children", {0}}, {"scale", {2, 2, 2}}}};
  file.json["scenes"] = {{{"nodes", {1}}}, {{"nodes", {2}}}};
  file.json["scene"] = 1;
  const Scene scene = loaded(file);
  ASSERT_EQ(scene.nodes.size(), 2u);
  EXPECT_EQ(scene.nodes[0].name, "root");
  EXPECT_EQ(scene.nodes[1].name, "leaf");
  EXPECT_EQ(scene.nodes[1].parent, 0u);
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].node, 1u);
  EXPECT_EQ(scene.bounds.low, glm::dvec3(0, 0, 2));
  EXPECT_EQ(scene.bounds.high, glm::dvec3(2, 2, 2));
}

TEST(GltfNodes, InstancesShareAMesh) {
  GltfBuilder file = triangle_file();
  file.node({{"mesh", 0}, {"translation", {5, 0, 0}}});
  const Scene scene = loaded(file);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.triangle_count, 2u);
}

/// A triangle, and below a node that is shown nowhere else: a triangle, a lamp, a spot and a camera.
GltfBuilder file_with_hidden(const json& transform) {
  GltfBuilder file = triangle_file();
  json node = {{"name", "hidden"}, {"mesh", 0}, {"children", {2, 3, 4, 5}}, {"translation", {0, 0, 7}}};
  node.update(transform);
  if (node.contains("matrix")) node.erase("translation");
  file.node(node);
  file.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 1}}, {"scale", {2, 2, 2}}});
  file.json["nodes"].push_back({{"extensions", file.light({{"type", "point"}})}});
  file.json["nodes"].push_back(
      {{"scale", {0, 0, 0}},
       {"extensions", file.light({{"type", "spot"}, {"spot", {{"outerConeAngle", 0.5}}}})}});
  file.json["nodes"].push_back({{"name", "camera:a"}, {"translation", {0, 1, 0}}});
  return file;
}

TEST(GltfNodes, OfScaleZeroAreHiddenWithWhatIsBelow) {
  const json flat = {1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 7, 1};
  for (const json& transform :
       {json{{"scale", {0, 0, 0}}}, json{{"scale", {0, 1, 0}}}, json{{"matrix", flat}}}) {
    const auto scene = load(file_with_hidden(transform));
    EXPECT_EQ(outcome_of(scene), "drawn") << transform;
    ASSERT_EQ(scene->instances.size(), 1u) << transform;
    EXPECT_EQ(scene->bounds.high, glm::dvec3(1, 1, 0));
    ASSERT_EQ(scene->lights.size(), 2u) << "light has no size";
    const SceneState state = state_at(*scene, Time{});
    EXPECT_NEAR(state.light_set.lights[0].position.v.z, 7, 1e-6);
    EXPECT_LT(glm::distance(state.light_set.lights[1].direction.v, glm::dvec3(0, 0, -1)), 1e-6);
    EXPECT_NEAR(scene->camera.value().translation.z, 7, 1e-6);
  }
  EXPECT_EQ(loaded(file_with_hidden({{"scale", {1, 0, 1}}})).instances.size(), 3u) << "flat, not hidden";
}

TEST(GltfNodes, OfScaleZeroThatAnAnimationGrowsAreShown) {
  GltfBuilder file = file_with_hidden({{"scale", {0, 0, 0}}});
  const auto keys = file.accessor(file.view<float>({0, 1}), 5126, "SCALAR", 2);
  const auto sizes = file.positions({{0, 0, 0}, {1, 1, 1}});
  file.json["animations"] = {
      {{"samplers", {{{"input", keys}, {"output", sizes}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "scale"}}}}}}}};
  EXPECT_EQ(loaded(file).instances.size(), 3u);
}

TEST(GltfNodes, ThatAreAllHiddenAreRefused) {
  GltfBuilder file = triangle_file();
  file.json["nodes"][0]["scale"] = {0, 0, 0};
  EXPECT_EQ(outcome_of(load(file)), "refused: nothing to draw: the scene has no triangles");
}

TEST(GltfNodes, AreMended) {
  GltfBuilder file = triangle_file();
  file.node({{"name", "a"}, {"mesh", 0}, {"rotation", {0, 0, 0, 0}}});
  file.node({{"name", "b"}, {"mesh", 0}, {"rotation", {0, 0, 3, 3}}});
  const auto scene = load(file);
  EXPECT_EQ(outcome_of(scene),
            "repaired: node 1 'a': its rotation is not a unit quaternion; it is made one (and 1 more)");
  EXPECT_EQ(scene->nodes[1].rest.rotation, glm::dquat(1, 0, 0, 0));
  EXPECT_LT(glm::length(scene->nodes[2].rest.rotation - glm::dquat(std::sqrt(0.5), 0, 0, std::sqrt(0.5))),
            1e-9);
}

/// A child of two nodes, one root below another, one that is named twice, and one below what is not shown.
TEST(GltfNodes, AreDrawnOnce) {
  GltfBuilder file = triangle_file();
  file.json["nodes"] = {{{"mesh", 0}, {"children", {1}}},
                        {{"mesh", 0}},
                        {{"mesh", 0}, {"children", {1, 77}}},
                        {{"children", {4}}, {"translation", {5, 0, 0}}},
                        {{"mesh", 0}}};
  file.json["scenes"][0]["nodes"] = {0, 1, 2, 2, 4, 99};
  const auto scene = load(file);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->instances.size(), 4u);
  EXPECT_EQ(scene->bounds.high, glm::dvec3(1, 1, 0));
  EXPECT_EQ(scene->warnings,
            (std::vector<std::string>{
                "repaired: node 1 has two parents, node 0 and node 2; it stays with the first",
                "repaired: node 2: there is no child node 77; it goes without (and 1 more)",
                "repaired: scene 0: node 1 is no root; it is drawn once (and 2 more)"}));
}

TEST(GltfAnimations, WhoseTimesRunBackwardsStandStill) {
  GltfBuilder file = rich_file();
  const auto keys = file.accessor(file.view<float>({0, 2, 1}), 5126, "SCALAR", 3);
  file.json["animations"][0]["name"] = "swing";
  file.json["animations"][0]["samplers"][0]["input"] = keys;
  const auto scene = load(file);
  EXPECT_EQ(outcome_of(scene), "repaired: animation 0 'swing', channel 0: key accessor " +
                                   std::to_string(keys) + ": its times should grow; it stands still");
  ASSERT_EQ(scene->channels.size(), 1u);
  EXPECT_EQ(scene->channels[0].path, Path::Rotation) << "the other channel moves";
}

TEST(GltfLights, OfALargeRangeHaveNoLimit) {
  for (const double range : {3.40282347e+38, 1e200, 1e30}) {
    GltfBuilder file = triangle_file();
    file.node({{"extensions", file.light({{"type", "point"}, {"range", range}})}});
    const auto scene = load(file);
    EXPECT_EQ(outcome_of(scene), "drawn") << range;
    EXPECT_FALSE(scene->lights.at(0).range_m.has_value()) << range;
  }
}

TEST(GltfLights, MayStandFarAwayIfTheyAreDirectional) {
  GltfBuilder file = triangle_file();
  file.node({{"translation", {0, 2e9, 0}}, {"extensions", file.light({{"type", "directional"}})}});
  const auto scene = load(file);
  EXPECT_EQ(outcome_of(scene), "drawn");
  EXPECT_EQ(scene->lights.size(), 1u);
}

TEST(GltfLights, OfALargeIntensityAreAsBrightAsCanBe) {
  GltfBuilder file = triangle_file();
  file.node({{"extensions", file.light({{"type", "point"}, {"intensity", 1e300}})}});
  EXPECT_EQ(loaded(file).lights.at(0).intensity, glm::vec3(1e30f));
}

TEST(GltfLights, AreMended) {
  GltfBuilder file = triangle_file();
  for (const json& light : {json{{"type", "laser"}}, json{{"type", 3}},
                            json{{"type", "point"}, {"color", {1, -1, 0.5}}, {"range", 0}},
                            json{{"type", "spot"}, {"spot", {{"innerConeAngle", 3}, {"outerConeAngle", 2}}}}})
    file.node({{"extensions", file.light(light)}});
  const auto scene = load(file);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->warnings.size(), 4u) << outcome_of(scene);
  ASSERT_EQ(scene->lights.size(), 2u);
  EXPECT_EQ(scene->lights[0].intensity, glm::vec3(1, 0, 0.5f));
  EXPECT_FALSE(scene->lights[0].range_m);
  EXPECT_FLOAT_EQ(scene->lights[1].outer_cone_rad, static_cast<float>(std::numbers::pi / 2));
  EXPECT_LT(scene->lights[1].inner_cone_rad, scene->lights[1].outer_cone_rad);
}

TEST(GltfMaterial, IsMended) {
  GltfBuilder file = rich_file();
  json& material = file.json["materials"][0];
  material["alphaMode"] = "FOG";
  material["pbrMetallicRoughness"]["baseColorFactor"] = {2, -1, 0.5, 1};
  file.json["samplers"][0]["wrapS"] = 7;
  const auto scene = load(file);
  EXPECT_EQ(outcome_of(scene),
            "repaired: material 0 'cloth': the base colour factor is outside of 0 to 1; it is cut off; "
            "repaired: material 0 'cloth': unknown alpha mode 'FOG'; it is opaque; "
            "repaired: sampler 0: unknown wrap mode 7; it repeats");
  EXPECT_EQ(scene->materials[0].base_color, glm::vec4(1, 0, 0.5f, 1));
  EXPECT_FALSE(scene->materials[0].alpha_cutoff);
  EXPECT_EQ(scene->textures[0].wrap_u, Wrap::Repeat);
  EXPECT_EQ(scene->textures[0].wrap_v, Wrap::MirroredRepeat);
}

TEST(GltfMesh, WithoutAnAttributeThatDoesNotFitIsDrawn) {
  GltfBuilder file = rich_file();
  file.json["accessors"][1]["count"] = 3;
  const auto scene = load(file);
  EXPECT_EQ(
      outcome_of(scene),
      "repaired: mesh 0 'chair', primitive 0: NORMAL accessor 1 has 3 elements for 4 vertices; it is drawn "
      "without this attribute");
  EXPECT_EQ(scene->meshes.at(0).normals.size(), 6u) << "the faces'";
}

TEST(GltfMesh, DrawsTheWholeTrianglesOfItsIndices) {
  GltfBuilder file = rich_file();
  file.json["accessors"][4]["count"] = 5;
  EXPECT_EQ(load(file)->triangle_count, 1u);
}

TEST(GltfLights, KeepTheOrderOfTheFile) {
  GltfBuilder file = triangle_file();
  const json first = file.light({{"type", "spot"},
                                 {"name", "a"},
                                 {"color", {1, 0.5, 0}},
                                 {"intensity", 4},
                                 {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.2}}}});
  const json second = file.light({{"type", "point"}, {"name", "b"}, {"range", 7}});
  file.node({{"extensions", second}});
  file.node({{"children", {3}}});
  file.json["nodes"].push_back({{"extensions", first}});
  const auto lights = loaded(file).lights;
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_EQ(lights[0].name, "a");
  EXPECT_EQ(lights[0].kind, LightKind::Spot);
  EXPECT_EQ(lights[0].intensity, glm::vec3(4, 2, 0));
  EXPECT_EQ(lights[0].inner_cone_rad, 0.1f);
  EXPECT_EQ(lights[0].outer_cone_rad, 0.2f);
  EXPECT_EQ(lights[1].kind, LightKind::Point);
  EXPECT_EQ(lights[1].range_m, 7.0f);
}

TEST(GltfLights, ASceneNeedsNoLight) {
  EXPECT_TRUE(loaded(triangle_file()).lights.empty());
}

TEST(GltfLights, LimitIsWhatAMaskHolds) {
  EXPECT_EQ(SceneLimits{}.lights, kMaxLights);
}

TEST(GltfCamera, IsTheNodeNamedForItElseTheFirstCamera) {
  GltfBuilder file = rich_file();
  EXPECT_EQ(loaded(file).camera.value().translation, glm::dvec3(0, 1, 3));
  file.node({{"name", "camera:reference"},
             {"translation", {4, 5, 6}},
             {"scale", {2, 3, 4}},
             {"rotation", {0, std::sqrt(0.5), 0, std::sqrt(0.5)}}});
  const auto camera = loaded(file).camera.value();
  EXPECT_EQ(camera.translation, glm::dvec3(4, 5, 6));
  EXPECT_NEAR(glm::length(camera.rotation), 1.0, 1e-12);
  const auto ahead = camera(Vector<Eye>{{0, 0, -1}}).v;
  EXPECT_LT(glm::distance(ahead, glm::dvec3(-1, 0, 0)), 1e-9);
}

TEST(GltfCamera, MirroredNodeGivesAProperRotation) {
  GltfBuilder file = triangle_file();
  file.node({{"name", "camera:mirrored"}, {"scale", {-1, 1, 1}}});
  const auto rotation = loaded(file).camera.value().rotation;
  EXPECT_NEAR(std::abs(rotation.w), 1.0, 1e-12);
}

TEST(GltfCamera, ASceneNeedsNoCamera) {
  EXPECT_FALSE(loaded(triangle_file()).camera.has_value());
}

TEST(SceneHashOf, ChangesWithWhatIsSeenAndNotWithNames) {
  const SceneHash hash = loaded(rich_file()).hash;
  EXPECT_EQ(loaded(rich_file()).hash, hash);
  GltfBuilder renamed = rich_file();
  renamed.json["meshes"][0]["name"] = "stool";
  EXPECT_EQ(loaded(renamed).hash, hash);
  const std::vector<std::pair<const char*, json>> changes = {
      {"/materials/0/doubleSided", true},
      {"/materials/0/alphaCutoff", 0.75},
      {"/samplers/0/wrapS", 10497},
      {"/nodes/2/translation", {0, 0, 1}},
      {"/extensions/KHR_lights_punctual/lights/0/range", 6},
      {"/extensions/KHR_lights_punctual/lights/1/intensity", 3},
      {"/animations/0/samplers/0/interpolation", "STEP"},
      {"/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset",
       {0.5, 0.5}}};
  for (const auto& [pointer, value] : changes) {
    GltfBuilder changed = rich_file();
    changed.json[json::json_pointer(pointer)] = value;
    EXPECT_NE(loaded(changed).hash, hash) << pointer;
  }
}

TEST(SceneHashOf, ChangesWithEveryByteThatIsShown) {
  const GltfBuilder file = triangle_file();
  const SceneHash hash = loaded(file).hash;
  GltfBuilder moved = file;
  moved.bytes()[12] ^= std::byte{1};
  EXPECT_NE(loaded(moved).hash, hash);
}

TEST(GltfLights, SpotHasTheDefaultConeOfTheExtension) {
  GltfBuilder file = rich_file();
  nlohmann::json& spot = file.json["extensions"]["KHR_lights_punctual"]["lights"][2];
  spot["spot"] = nlohmann::json::object();
  const auto scene = load(file);
  ASSERT_TRUE(scene.has_value()) << scene.error().what;
  const auto found = std::ranges::find(scene->lights, LightKind::Spot, &LightSource::kind);
  ASSERT_NE(found, scene->lights.end());
  EXPECT_EQ(found->inner_cone_rad, 0.0f);
  EXPECT_EQ(found->outer_cone_rad, static_cast<float>(std::numbers::pi / 4));
}

}  // namespace
}  // namespace farshade
