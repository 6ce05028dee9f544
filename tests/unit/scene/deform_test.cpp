/// Skins and morph targets, still and animated, and what a file asks for that is not drawn.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "stereo/scene/mesh_parts.h"
#include "stereo/scene/moving_bounds.h"
#include "stereo/scene/scene_state.h"
#include "tests/unit/gltf/gltf_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr int kByte = 5121, kFloat = 5126;

Scene scene_of(const GltfBuilder& file) {
  Expected<Scene> scene = load_scene_from_memory(file.glb());
  if (!scene) throw std::runtime_error(scene.error().what);
  return std::move(*scene);
}

/// The triangle (0,0,0) (1,0,0) (0,1,0). Its first two vertices belong to joint 0, the third to both joints
/// by half. Joint 0 is node 1, which stands at (0,0,5). Joint 1 is node 2, 2 m above its parent, joint 0,
/// turned by 90 degrees about z. The mesh's own node is moved by (100,0,0), which does not count.
GltfBuilder skinned_file() {
  GltfBuilder file = triangle_file();
  const std::vector<std::uint8_t> joints{0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0};
  const std::vector<float> weights{1, 0, 0, 0, 3, 0, 0, 0, 0.25f, 0.25f, 0, 0};
  // Joint 1 was bound 2 m above the origin.
  const std::vector<float> inverse_bind{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                        1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -2, 0, 1};
  json& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["JOINTS_0"] = file.accessor(file.view(joints), kByte, "VEC4", 3);
  primitive["attributes"]["WEIGHTS_0"] = file.accessor(file.view(weights), kFloat, "VEC4", 3);
  const auto matrices = file.accessor(file.view(inverse_bind), kFloat, "MAT4", 2);
  file.json["nodes"][0]["skin"] = 0;
  file.json["nodes"][0]["translation"] = {100, 0, 0};
  file.node({{"name", "hip"}, {"translation", {0, 0, 5}}, {"children", {2}}});
  const double half = std::sqrt(0.5);
  file.json["nodes"].push_back(
      {{"name", "knee"}, {"translation", {0, 2, 0}}, {"rotation", {0, 0, half, half}}});
  file.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", matrices}}};
  return file;
}

/// The corners of the only triangle in the stage.
std::vector<glm::dvec3> corners_of(const Scene& scene) {
  const SceneState state = state_at(scene, Time{});
  std::vector<glm::dvec3> corners;
  const Mesh& mesh = scene.meshes.at(0);
  for (int i = 0; i < 3; ++i)
    corners.push_back(
        state.stage_from_object.at(0)(Point<Object>{glm::dvec3(mesh.positions[mesh.triangles[0][i]])}).v);
  return corners;
}

/// The same at a time of the animation, for a scene with a rig.
std::vector<glm::dvec3> deformed_corners(const Scene& scene, Duration time) {
  const SceneState state = state_at(scene, Time(time));
  const Mesh& mesh = scene.meshes.at(0);
  const Deformation deformation(mesh.deformable.value(), state.rigs.at(0));
  std::vector<glm::dvec3> corners;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 position(deformation.vertex(mesh.triangles[0][i]).position);
    corners.push_back(state.stage_from_object.at(0)(Point<Object>{position}).v);
  }
  return corners;
}

void expect_near(const std::vector<glm::dvec3>& found, const std::vector<glm::dvec3>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_LT(glm::length(found[i] - expected[i]), 1e-5)
        << i << ": " << found[i].x << ' ' << found[i].y << ' ' << found[i].z;
}

TEST(Skin, StandsInThePoseOfItsJoints) {
  const Scene scene = scene_of(skinned_file());
  // (0,1,0) by joint 0 is (0,1,5). By joint 1: bound at (0,-1,0), turned to (1,0,0), and placed at (1,2,5).
  expect_near(corners_of(scene), {{0, 0, 5}, {1, 0, 5}, {0.5, 1.5, 5}});
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(scene.rigs.empty()) << "nothing moves";
  EXPECT_FALSE(scene.meshes[0].deformable);
  EXPECT_LT(glm::length(scene.bounds.low - glm::dvec3(0, 0, 5)), 1e-5);
}

TEST(Skin, TurnsItsNormals) {
  GltfBuilder file = skinned_file();
  const std::vector<glm::vec3> normals(3, glm::vec3(0, 1, 0));
  file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      file.accessor(file.view(normals), kFloat, "VEC3", 3);
  const Scene scene = scene_of(file);
  EXPECT_LT(glm::length(scene.meshes[0].normals[0] - glm::vec3(0, 1, 0)), 1e-5f);
  // Half of the third vertex turns by 90 degrees.
  EXPECT_LT(glm::length(scene.meshes[0].normals[2] - glm::normalize(glm::vec3(-1, 1, 0))), 1e-5f);
}

/// Joint 0 goes from (0,0,7) to (0,9,0) within a second.
GltfBuilder moving_file() {
  GltfBuilder file = skinned_file();
  const auto keys =
      file.accessor(file.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2, {{"min", {0}}, {"max", {1}}});
  const auto places =
      file.accessor(file.view(std::vector<glm::vec3>{{0, 0, 7}, {0, 9, 0}}), kFloat, "VEC3", 2);
  file.json["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}}},
       {"samplers", {{{"input", keys}, {"output", places}}}}}};
  return file;
}

TEST(Skin, FollowsItsJointsThroughTheAnimation) {
  const Scene scene = scene_of(moving_file());
  expect_near(corners_of(scene), {{0, 0, 7}, {1, 0, 7}, {0.5, 1.5, 7}});
  ASSERT_EQ(scene.rigs.size(), 1u);
  expect_near(deformed_corners(scene, 0ms), {{0, 0, 7}, {1, 0, 7}, {0.5, 1.5, 7}});
  expect_near(deformed_corners(scene, 500ms), {{0, 4.5, 3.5}, {1, 4.5, 3.5}, {0.5, 6, 3.5}});
  EXPECT_TRUE(can_move(scene, scene.instances.at(0)));
}

// Float has steps of 1 m there.
TEST(Skin, KeepsItsShapeFarFromTheOrigin) {
  GltfBuilder file = moving_file();
  file.json["nodes"].push_back({{"name", "far"}, {"translation", {1e7, 0, 0}}, {"children", {1}}});
  auto& roots = file.json["scenes"][0]["nodes"];
  for (json& root : roots)
    if (root == 1) root = 3;
  expect_near(deformed_corners(scene_of(file), 500ms),
              {{1e7, 4.5, 3.5}, {1e7 + 1, 4.5, 3.5}, {1e7 + 0.5, 6, 3.5}});
}

TEST(Skin, BoundsHoldItsVertices) {
  const Scene scene = scene_of(moving_file());
  const DeformBounds bounds(*scene.meshes[0].deformable);
  for (int ms = 0; ms < 1000; ms += 50) {
    const SceneState state = state_at(scene, Time(std::chrono::milliseconds(ms)));
    const Bounds box = bounds.at(state.rigs[0]);
    for (const glm::dvec3& corner : deformed_corners(scene, std::chrono::milliseconds(ms))) {
      const glm::dvec3 p = corner - glm::dvec3(state.stage_from_object[0].matrix[3]);
      EXPECT_EQ(p, glm::clamp(p, box.low - 1e-5, box.high + 1e-5));
    }
    EXPECT_LT(glm::length(box.high - box.low), 4);
  }
}

TEST(Skin, WithoutAJointOfAVertexIsLeftOut) {
  GltfBuilder file = skinned_file();
  file.json["skins"][0]["joints"] = {1};
  const Expected<Scene> scene = load_scene_from_memory(file.glb());
  EXPECT_NE(outcome_of(scene).find("a joint that its skin does not have; meshes are drawn without it"),
            std::string::npos)
      << outcome_of(scene);
  EXPECT_TRUE(scene->rigs.empty());
}

TEST(Skin, RefusesVerticesBeyondTheLimit) {
  GltfBuilder file = skinned_file();
  file.json["nodes"][1]["scale"] = {1e10, 1, 1};
  const Expected<Scene> scene = load_scene_from_memory(file.glb());
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().fault, Fault::OutOfRange) << scene.error().what;
}

// Each node makes its own copy of the vertices and indices.
TEST(Skin, RefusesThatASmallFileDeformsAMeshVeryOften) {
  GltfBuilder file = skinned_file();
  std::vector<std::uint8_t> indices(3 * 100'000);
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint8_t>(i % 3);
  file.json["meshes"][0]["primitives"][0]["indices"] =
      file.accessor(file.view(indices), kByte, "SCALAR", indices.size());
  for (int i = 0; i < 100; ++i) file.node({{"mesh", 0}, {"skin", 0}});
  const Expected<Scene> scene = load_scene_from_memory(file.glb());
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().fault, Fault::OutOfRange);
  EXPECT_NE(scene.error().what.find("more often"), std::string::npos) << scene.error().what;
}

TEST(Skin, RefusesMoreMatricesThanASmallFileShouldHave) {
  GltfBuilder file = skinned_file();
  const std::size_t matrices = file.json["skins"][0]["inverseBindMatrices"];
  file.json["accessors"][matrices].erase("bufferView");
  file.json["accessors"][matrices]["count"] = 1 << 20;
  const Expected<Scene> scene = load_scene_from_memory(file.glb());
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().what.find("more joints"), std::string::npos) << scene.error().what;
}

// A mirrored skin turns its triangles over, so that they are seen from the same side as before.
TEST(Skin, TurnsMirroredTrianglesOver) {
  GltfBuilder file = skinned_file();
  file.json["nodes"][1]["scale"] = {-1, 1, 1};
  file.json["nodes"][1]["translation"] = {0, 0, 0};
  const Scene scene = scene_of(file);
  EXPECT_GT(scene.meshes[0].normals[0].z, 0.9f);
}

TEST(MorphTargets, AreAddedWithTheWeightsOfTheNodeOrElseOfTheMesh) {
  GltfBuilder file = triangle_file();
  const auto up =
      file.accessor(file.view(std::vector<glm::vec3>{{0, 0, 0}, {0, 4, 0}, {0, 0, 8}}), kFloat, "VEC3", 3);
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", up}}};
  expect_near(corners_of(scene_of(file)), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  file.json["meshes"][0]["weights"] = {0.5};
  expect_near(corners_of(scene_of(file)), {{0, 0, 0}, {1, 2, 0}, {0, 1, 4}});
  file.json["nodes"][0]["weights"] = {0.25};
  expect_near(corners_of(scene_of(file)), {{0, 0, 0}, {1, 1, 0}, {0, 1, 2}});
}

TEST(MorphTargets, OfHugeNormalsLeaveNormalsUnit) {
  GltfBuilder file = triangle_file();
  json& primitive = file.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["NORMAL"] =
      file.accessor(file.view(std::vector<glm::vec3>(3, {0, 0, 1})), kFloat, "VEC3", 3);
  const auto huge = file.accessor(file.view(std::vector<glm::vec3>(3, {3e38f, 0, 0})), kFloat, "VEC3", 3);
  primitive["targets"] = {{{"NORMAL", huge}}};
  file.json["meshes"][0]["weights"] = {1e10};
  const Scene scene = scene_of(file);
  for (const glm::vec3& normal : scene.meshes[0].normals) EXPECT_NEAR(glm::length(normal), 1, 1e-5);
}

TEST(MorphTargets, OfANodeThatIsNotThereStandStill) {
  GltfBuilder file = triangle_file();
  file.json["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 2'000'000'000}, {"path", "weights"}}}}}},
       {"samplers", json::array()}}};
  const Expected<Scene> scene = load_scene_from_memory(file.glb());
  EXPECT_NE(outcome_of(scene).find("there is no node 2000000000; it stands still"), std::string::npos)
      << outcome_of(scene);
}

/// The triangle of triangle_file, whose first two targets move its second vertex by 4 m along y and z. Their
/// weights go from 0 to (1, 0.5) within a second.
GltfBuilder morphing_file() {
  GltfBuilder file = triangle_file();
  const auto along = [&](const glm::vec3& to) {
    return file.accessor(file.view(std::vector<glm::vec3>{{0, 0, 0}, to, {0, 0, 0}}), kFloat, "VEC3", 3);
  };
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", along({0, 4, 0})}},
                                                        {{"POSITION", along({0, 0, 4})}}};
  const auto keys = file.accessor(file.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
  const auto weights = file.accessor(file.view(std::vector<float>{0, 0, 1, 0.5f}), kFloat, "SCALAR", 4);
  file.json["animations"] = {
      {{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
       {"samplers", {{{"input", keys}, {"output", weights}}}}}};
  return file;
}

TEST(MorphTargets, FollowTheirWeightsThroughTheAnimation) {
  const Scene scene = scene_of(morphing_file());
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.animation_length_s, 1);
  expect_near(deformed_corners(scene, 0ms), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  expect_near(deformed_corners(scene, 500ms), {{0, 0, 0}, {1, 2, 1}, {0, 1, 0}});
}

TEST(MorphTargets, FollowSplinesAndSteps) {
  GltfBuilder file = morphing_file();
  json& sampler = file.json["animations"][0]["samplers"][0];
  sampler["interpolation"] = "STEP";
  expect_near(deformed_corners(scene_of(file), 500ms), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  sampler["interpolation"] = "CUBICSPLINE";
  // In-tangents, values and out-tangents of both keys. The first target leaves with 2 and arrives with 0.
  sampler["output"] =
      file.accessor(file.view(std::vector<float>{0, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0}), kFloat, "SCALAR", 12);
  // Hermite at one half: (0 + 1) / 2 + 2 / 8.
  expect_near(deformed_corners(scene_of(file), 500ms), {{0, 0, 0}, {1, 3, 0}, {0, 1, 0}});
}

TEST(MorphTargets, WithAnotherNumberOfWeightsStandStill) {
  GltfBuilder file = morphing_file();
  file.json["animations"][0]["samplers"][0]["output"] =
      file.accessor(file.view(std::vector<float>{0, 0, 1}), kFloat, "SCALAR", 3);
  const Expected<Scene> scene = load_scene_from_memory(file.glb());
  EXPECT_NE(outcome_of(scene).find("has 3 elements, should have 4; it stands still"), std::string::npos)
      << outcome_of(scene);
  EXPECT_TRUE(scene->rigs.empty());
}

TEST(MorphTargets, OfANodeWithoutAMeshDoNothing) {
  GltfBuilder file = morphing_file();
  file.node({{"name", "empty"}});
  file.json["animations"][0]["channels"][0]["target"]["node"] = 1;
  const Scene scene = scene_of(file);
  EXPECT_TRUE(scene.rigs.empty());
  EXPECT_EQ(scene.animation_length_s, 0);
}

TEST(MorphTargets, WhoseAnimatedWeightsAreConstantStandStill) {
  GltfBuilder file = morphing_file();
  file.json["animations"][0]["samplers"][0]["output"] =
      file.accessor(file.view(std::vector<float>{1, 0.5f, 1, 0.5f}), kFloat, "SCALAR", 4);
  const Scene scene = scene_of(file);
  EXPECT_TRUE(scene.rigs.empty());
  expect_near(corners_of(scene), {{0, 0, 0}, {1, 4, 2}, {0, 1, 0}});
}

TEST(MorphTargets, AnimatedInAMeshThatHasNoneDoNothing) {
  GltfBuilder file = morphing_file();
  file.json["meshes"][0]["primitives"][0].erase("targets");
  EXPECT_TRUE(scene_of(file).rigs.empty());
}

// Each would have its own copy of every target.
TEST(MorphTargets, RefusesThatASmallFileMakesMuchOfThem) {
  GltfBuilder many = morphing_file();
  json& targets = many.json["meshes"][0]["primitives"][0]["targets"];
  const json first = targets[0];
  while (targets.size() < 1000) targets.push_back(first);
  many.json["animations"][0]["samplers"][0]["output"] =
      many.accessor(many.view(std::vector<float>(2000, 0.5f)), kFloat, "SCALAR", 2000);
  std::vector<std::uint8_t> indices(30'000, 0);
  many.json["meshes"][0]["primitives"][0]["indices"] =
      many.accessor(many.view(indices), kByte, "SCALAR", indices.size());
  const Expected<Scene> scene = load_scene_from_memory(many.glb());
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().what.find("more often"), std::string::npos) << scene.error().what;
}

TEST(Deformation, KeepsVerticesWithinWhatFloatCanCompute) {
  GltfBuilder file = morphing_file();
  file.json["animations"][0]["samplers"][0]["output"] =
      file.accessor(file.view(std::vector<float>{0, 0, 3e38f, 3e38f}), kFloat, "SCALAR", 4);
  const Scene scene = scene_of(file);
  const SceneState state = state_at(scene, Time(999ms));
  const glm::vec3 p = Deformation(*scene.meshes[0].deformable, state.rigs[0]).vertex(1).position;
  EXPECT_LE(glm::length(p), 1e7f);
}

/// A strip of triangles in the xy plane, one triangle every 1 m.
TEST(MeshParts, HaveEveryTriangleOnceAndFollowTheSameRig) {
  Mesh mesh;
  mesh.name = "strip";
  constexpr std::uint32_t kTriangles = 1000;
  Deformable deformable;
  for (std::uint32_t i = 0; i < kTriangles + 2; ++i) {
    deformable.positions.emplace_back(i, i % 2, 0);
    deformable.normals.emplace_back(0, 0, 1);
    deformable.influences.push_back({glm::u16vec4(0), glm::vec4(1, 0, 0, 0)});
    if (i < kTriangles) mesh.triangles.emplace_back(i, i + 1 + i % 2, i + 2 - i % 2);
  }
  mesh.positions = deformable.positions, mesh.normals = deformable.normals;
  mesh.deformable = deformable;
  std::set<float> places;
  for (const Mesh& part : parts_of(mesh)) {
    EXPECT_LE(part.triangles.size(), kPartTriangles);
    EXPECT_EQ(part.deformable->positions, part.positions);
    EXPECT_EQ(part.deformable->influences.size(), part.positions.size());
    for (const glm::uvec3& t : part.triangles)
      places.insert(std::min({part.positions[t.x].x, part.positions[t.y].x, part.positions[t.z].x}));
  }
  EXPECT_EQ(places.size(), kTriangles);
}

TEST(LookExtensions, AreLeftOutWithOneWarningEach) {
  GltfBuilder file = triangle_file();
  file.json["extensionsRequired"] = {"KHR_materials_unlit", "KHR_texture_basisu"};
  file.json["extensionsUsed"] = {"KHR_materials_unlit", "KHR_materials_clearcoat", "KHR_texture_basisu"};
  file.json["textures"] = {{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}, json::object()};
  file.json["materials"] = json::array();
  for (int i = 0; i < 2; ++i)
    file.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
  json& primitives = file.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[0]["material"] = 0;
  primitives[1]["material"] = 1;
  const Scene scene = scene_of(file);
  EXPECT_EQ(scene.warnings.size(), 3u);
  EXPECT_TRUE(scene.textures.empty());
  EXPECT_NE(scene.warnings[1].find("KHR_materials_unlit"), std::string::npos);
  EXPECT_NE(scene.warnings[2].find("textures without a PNG, JPEG or WebP"), std::string::npos);
}

TEST(MovingBounds, HoldADeformedMeshAtEachTime) {
  const Scene scene = scene_of(moving_file());
  MovingBounds bounds(scene);
  for (const Duration time : {0ms, 250ms, 500ms, 999ms, 100ms}) {
    const Bounds at = bounds.at(Time(time));
    for (const glm::dvec3& p : deformed_corners(scene, time))
      EXPECT_TRUE(glm::all(glm::lessThanEqual(at.low, p)) && glm::all(glm::greaterThanEqual(at.high, p)))
          << time.count() << ": " << p.x << ' ' << p.y << ' ' << p.z;
    EXPECT_LT(glm::length(at.high - at.low), 5);
  }
}

}  // namespace
}  // namespace farshade
