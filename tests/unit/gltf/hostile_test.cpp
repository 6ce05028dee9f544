/// Wrong glTF files: each is repaired with one warning that names the place, or refused with such a sentence.
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "tests/unit/gltf/gltf_builder.h"
#include "tests/unit/image/image_files.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

using nlohmann::json;
using Change = std::pair<const char*, json>;  ///< JSON pointer and its new value; null removes the member

/// One change that makes rich_file() wrong, and what the sentence must contain.
struct Spoiled {
  const char* name;
  std::vector<Change> changes;
  const char* says;
  Fault fault = Fault::Malformed;
};

void PrintTo(const Spoiled& spoiled, std::ostream* out) {
  *out << spoiled.name;
}

GltfBuilder spoil(const std::vector<Change>& changes) {
  GltfBuilder file = rich_file();
  for (const auto& [pointer, value] : changes) {
    const json::json_pointer at(pointer);
    if (value.is_null())
      file.json.at(at.parent_pointer()).erase(at.back());
    else
      file.json[at] = value;
  }
  return file;
}

/// A spoiled file and one more mesh, of which nothing is spoiled.
class GltfRepair : public testing::TestWithParam<Spoiled> {};

TEST_P(GltfRepair, DrawsTheRestWithOneWarningThatNamesThePlace) {
  GltfBuilder file = spoil(GetParam().changes);
  file.mesh({{"attributes", {{"POSITION", file.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})}}}});
  const auto scene = load(file);
  ASSERT_TRUE(scene.has_value()) << scene.error().what;
  EXPECT_GE(scene->triangle_count, 1u);
  ASSERT_EQ(scene->warnings.size(), 1u) << scene->warnings.at(1);
  EXPECT_TRUE(scene->warnings[0].starts_with("repaired: ")) << scene->warnings[0];
  EXPECT_NE(scene->warnings[0].find(GetParam().says), std::string::npos) << scene->warnings[0];
}

class GltfRefusal : public testing::TestWithParam<Spoiled> {};

TEST_P(GltfRefusal, NamesTheObject) {
  const auto scene = load(spoil(GetParam().changes));
  ASSERT_FALSE(scene.has_value());
  EXPECT_NE(scene.error().what.find(GetParam().says), std::string::npos) << scene.error().what;
  EXPECT_EQ(scene.error().fault, GetParam().fault) << scene.error().what;
  EXPECT_EQ(scene.error().what.find('\n'), std::string::npos) << "one sentence";
}

constexpr auto kHuge = std::uint64_t{1} << 52;
const json kPath = {{"node", 0}, {"path", "translation"}};

const json kBentMatrix = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

INSTANTIATE_TEST_SUITE_P(
    Shape, GltfRepair,
    testing::Values(
        Spoiled{"NoAsset", {{"/asset", nullptr}}, "asset.version is missing"},
        Spoiled{"IndexIsText",
                {{"/meshes/0/primitives/0/indices", "4"}},
                "meshes[0].primitives[0].indices should be"},
        Spoiled{"IndexNegative", {{"/nodes/0/mesh", -1}}, "nodes[0].mesh should be a whole number"},
        Spoiled{"IndexBeyond32Bits", {{"/nodes/0/mesh", std::uint64_t{1} << 32}}, "nodes[0].mesh should be"},
        Spoiled{"CountIsFraction", {{"/accessors/0/count", 1.5}}, "accessors[0].count should be"},
        Spoiled{"CountZero", {{"/accessors/0/count", 0}}, "accessors[0].count should be"},
        Spoiled{"TranslationTooShort",
                {{"/nodes/0/translation", {1, 2}}},
                "nodes[0].translation should be a list of 3"},
        Spoiled{
            "TranslationTooFar", {{"/nodes/0/translation", {1e300, 0, 0}}}, "nodes[0].translation should be"},
        Spoiled{"NodeLightIsText",
                {{"/nodes/1/extensions/KHR_lights_punctual/light", "x"}},
                "nodes[1].extensions.KHR_lights_punctual.light should be"}));

INSTANTIATE_TEST_SUITE_P(
    Accessors, GltfRepair,
    testing::Values(
        Spoiled{"ViewBufferMissing", {{"/bufferViews/0/buffer", 7}}, "buffer view 0: there is no buffer 7"},
        Spoiled{"ViewBeyondBuffer",
                {{"/bufferViews/0/byteLength", 1 << 20}},
                "buffer view 0 reads beyond its buffer"},
        Spoiled{"ViewOffsetHuge",
                {{"/bufferViews/0/byteOffset", kHuge}},
                "buffer view 0 reads beyond its buffer"},
        Spoiled{"AccessorViewMissing",
                {{"/accessors/0/bufferView", 99}},
                "accessor 0: there is no buffer view 99"},
        Spoiled{
            "AccessorBeyondView", {{"/accessors/0/count", 5}}, "accessor 0 reads beyond its buffer view 0"},
        Spoiled{"AccessorOffsetHuge",
                {{"/accessors/0/byteOffset", kHuge}},
                "accessor 0 reads beyond its buffer view 0"},
        Spoiled{"AccessorCountHuge", {{"/accessors/0/count", kHuge}}, "accessor 0 reads beyond"},
        Spoiled{"ZerosWithoutEnd",
                {{"/accessors/0/bufferView", nullptr}, {"/accessors/0/count", 1 << 30}},
                "accessor 0: 1073741824 elements are more than"},
        Spoiled{"StrideBelowElement", {{"/bufferViews/0/byteStride", 8}}, "accessor 0: the stride"},
        Spoiled{"StrideZero", {{"/bufferViews/0/byteStride", 0}}, "buffer view 0: its stride"},
        Spoiled{"StrideOdd", {{"/bufferViews/6/byteStride", 2}}, "buffer view 6: its stride"},
        Spoiled{"StrideBeyondView", {{"/bufferViews/0/byteStride", 24}}, "accessor 0 reads beyond"},
        Spoiled{"ComponentUnknown",
                {{"/accessors/0/componentType", 5124}},
                "accessors[0].componentType should be 5120"},
        Spoiled{"TypeUnknown", {{"/accessors/0/type", "VEC5"}}, "accessors[0].type should be SCALAR"},
        Spoiled{"SparseIndexBeyond",
                {{"/accessors/0/count", 2}, {"/accessors/0/sparse/count", 1}},
                "accessor 0: its sparse indices should grow and stay below 2"},
        Spoiled{"SparseTooMany", {{"/accessors/0/sparse/count", 5}}, "accessor 0: has 5 sparse elements"},
        Spoiled{"ViewUnaligned", {{"/bufferViews/0/byteOffset", 2}}, "accessor 0 is not aligned"},
        Spoiled{"SparseIndicesBeyondView",
                {{"/accessors/0/sparse/count", 2}},
                "accessor 0: its sparse indices read beyond"},
        Spoiled{"SparseViewMissing",
                {{"/accessors/0/sparse/values/bufferView", 99}},
                "accessor 0: its sparse part: there is no buffer view 99"},
        Spoiled{"SparseIndexSigned",
                {{"/accessors/0/sparse/indices/componentType", 5120}},
                "accessor 0: sparse indices should be unsigned"}));

INSTANTIATE_TEST_SUITE_P(
    Meshes, GltfRepair,
    testing::Values(
        Spoiled{"PositionMissing",
                {{"/meshes/0/primitives/0/attributes/POSITION", 50}},
                "mesh 0 'chair', primitive 0: POSITION accessor 50 is not there"},
        Spoiled{"PositionIsPair",
                {{"/accessors/0/type", "VEC2"}},
                "mesh 0 'chair', primitive 0: POSITION accessor 0 has a type"},
        Spoiled{"NormalCountDiffers",
                {{"/accessors/1/count", 3}},
                "mesh 0 'chair', primitive 0: NORMAL accessor 1 has 3 elements for 4 vertices"},
        Spoiled{"IndicesAreFloats",
                {{"/meshes/0/primitives/0/indices", 2}},
                "mesh 0 'chair', primitive 0: index accessor 2 should hold unsigned"},
        Spoiled{"IndicesMissing",
                {{"/meshes/0/primitives/0/indices", 77}},
                "mesh 0 'chair', primitive 0: index accessor 77 is not there"},
        Spoiled{"IndicesNotWhole",
                {{"/accessors/4/count", 5}},
                "primitive 0: 5 vertices do not make whole triangles"},
        Spoiled{"ModeUnknown",
                {{"/meshes/0/primitives/0/mode", 9}},
                "mesh 0 'chair', primitive 0: unknown mode 9"},
        Spoiled{"MaterialMissing",
                {{"/meshes/0/primitives/0/material", 4}},
                "mesh 0 'chair', primitive 0: there is no material 4"},
        Spoiled{"TextureMissing",
                {{"/materials/0/pbrMetallicRoughness/baseColorTexture/index", 3}},
                "material 0 'cloth': there is no texture 3"},
        Spoiled{"ImageMissing", {{"/textures/0/source", 3}}, "texture 0: there is no image 3"},
        Spoiled{"ImageViewMissing", {{"/images/0/bufferView", 999}}, "image 0: there is no buffer view 999"},
        Spoiled{"ImageIsNone", {{"/images/0/bufferView", 0}}, "image 0: ", Fault::Unsupported},
        Spoiled{"SamplerMissing", {{"/textures/0/sampler", 3}}, "texture 0: there is no sampler 3"},
        Spoiled{"WrapUnknown", {{"/samplers/0/wrapS", 1}}, "sampler 0: unknown wrap mode"},
        Spoiled{"AlphaModeUnknown",
                {{"/materials/0/alphaMode", "FOG"}},
                "material 0 'cloth': unknown alpha mode 'FOG'"},
        Spoiled{"FactorBeyondOne",
                {{"/materials/0/pbrMetallicRoughness/baseColorFactor", {1, 1, 2, 1}}},
                "material 0 'cloth': the base colour"},
        Spoiled{"LightTypeUnknown",
                {{"/extensions/KHR_lights_punctual/lights/0/type", "laser"}},
                "light 0: unknown type 'laser'"},
        Spoiled{"SpotWithoutCone",
                {{"/extensions/KHR_lights_punctual/lights/2/spot", nullptr}},
                "light 2 is a spot without a cone"},
        Spoiled{"ConeInsideOut",
                {{"/extensions/KHR_lights_punctual/lights/2/spot/innerConeAngle", 0.6}},
                "light 2: the cone"}));

INSTANTIATE_TEST_SUITE_P(
    Nodes, GltfRepair,
    testing::Values(
        Spoiled{"ChildMissing", {{"/nodes/0/children", {9}}}, "node 0 'seat': there is no child node 9"},
        Spoiled{
            "TwoParents", {{"/nodes/2/children", {1}}}, "node 1 'lamp' has two parents, node 0 and node 2"},
        Spoiled{"RootHasParent", {{"/scenes/0/nodes", {0, 1}}}, "scene 0: node 1 'lamp' is no root"},
        Spoiled{"RootTwice", {{"/scenes/0/nodes", {0, 0}}}, "scene 0: node 0 'seat' is named twice"},
        Spoiled{"RootMissing", {{"/scenes/0/nodes", {42}}}, "scene 0: there is no node 42"},
        Spoiled{"SceneMissing", {{"/scene", 5}}, "the default scene 5 is not there"},
        Spoiled{"MeshMissing", {{"/nodes/0/mesh", 5}}, "node 0 'seat': there is no mesh 5"},
        Spoiled{"LightMissing",
                {{"/nodes/1/extensions/KHR_lights_punctual/light", 5}},
                "node 1 'lamp': there is no light 5"},
        Spoiled{"CameraMissing", {{"/nodes/4/camera", 5}}, "node 4 'eye': there is no camera 5"},
        Spoiled{"RotationNotUnit", {{"/nodes/1/rotation", {0, 0, 0, 0}}}, "node 1 'lamp': its rotation"},
        Spoiled{"LampTooFar", {{"/nodes/1/translation", {2e9, 0, 0}}}, "a light lies more than 1e9 m"},
        Spoiled{"CameraTooFar", {{"/nodes/4/translation", {2e9, 0, 0}}}, "the camera lies more than 1e9 m"},
        Spoiled{"MatrixProjects",
                {{"/nodes/1/matrix", kBentMatrix}},
                "node 1 'lamp': the last row of its matrix"},
        Spoiled{"MatrixAndScale",
                {{"/nodes/4/matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}},
                "node 4 'eye' has both"},
        Spoiled{"SkinMissing", {{"/nodes/0/skin", 0}}, "node 0 'seat': there is no skin 0"},
        Spoiled{"ImageOfBoth", {{"/images/0/uri", "x.png"}}, "image 0 has both a URI and a buffer view"},
        Spoiled{"ImageOfNeither", {{"/images/0", json::object()}}, "image 0: it has neither"},
        Spoiled{"RangeNegative", {{"/extensions/KHR_lights_punctual/lights/0/range", -1}}, "range should be"},
        Spoiled{"IntensityNegative",
                {{"/extensions/KHR_lights_punctual/lights/0/intensity", -1}},
                "intensity should be"},
        Spoiled{"CutoffNegative", {{"/materials/0/alphaCutoff", -1}}, "alphaCutoff should be"},
        Spoiled{
            "SkinWithoutJoints", {{"/skins", json::array({json::object()})}}, "skins[0].joints is missing"},
        Spoiled{"SkinOfNoJoint",
                {{"/skins", json::array({{{"joints", json::array()}}})}},
                "skins[0].joints should be"},
        Spoiled{
            "JointMissing", {{"/skins", json::array({{{"joints", {99}}}})}}, "skin 0: there is no node 99"},
        Spoiled{"InverseBindMissing",
                {{"/skins", json::array({{{"joints", {0}}, {"inverseBindMatrices", 99}}})}},
                "accessor 99 is not there"},
        Spoiled{"InverseBindNoMatrices",
                {{"/skins", json::array({{{"joints", {0}}, {"inverseBindMatrices", 0}}})}},
                "a matrix of floats for each joint"},
        Spoiled{"MorphTargetMissing",
                {{"/meshes/0/primitives/0/targets", json::array({{{"POSITION", 99}}})}},
                "morph target: POSITION accessor 99 is not there"}));

INSTANTIATE_TEST_SUITE_P(
    Animations, GltfRepair,
    testing::Values(
        Spoiled{"NodeMissing",
                {{"/animations/0/channels/0/target/node", 9}},
                "animation 0, channel 0: there is no node 9"},
        Spoiled{
            "SamplerMissing", {{"/animations/0/channels/0/sampler", 9}}, "channel 0: there is no sampler 9"},
        Spoiled{"PathUnknown",
                {{"/animations/0/channels/0/target/path", "mood"}},
                "channel 0: unknown path 'mood'"},
        Spoiled{"SameTarget",
                {{"/animations/0/channels/1/target", kPath}, {"/animations/0/channels/1/sampler", 0}},
                "channel 1: an earlier channel moves the same"},
        Spoiled{"InterpolationUnknown",
                {{"/animations/0/samplers/0/interpolation", "JUMP"}},
                "channel 0: unknown interpolation 'JUMP'"},
        Spoiled{"KeysMissing", {{"/animations/0/samplers/0/input", 99}}, "key accessor 99 is not there"},
        Spoiled{"KeysDoNotGrow", {{"/animations/0/samplers/0/input", 8}}, "key accessor 8"},
        Spoiled{"ValuesTooFew",
                {{"/animations/0/samplers/0/interpolation", "CUBICSPLINE"}},
                "has 3 elements, should have 9"},
        Spoiled{"ValuesOfOtherType",
                {{"/animations/0/samplers/1/output", 6}},
                "channel 1: value accessor 6 has a type"},
        Spoiled{"TargetHasMatrix",
                {{"/nodes/0/matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}},
                "node 0 'seat' has a matrix and cannot be animated"}));

INSTANTIATE_TEST_SUITE_P(
    Limits, GltfRefusal,
    testing::Values(
        Spoiled{"NodesNoList", {{"/nodes", 3}}, "nodes should be a list of objects"},
        Spoiled{"OtherVersion", {{"/asset/version", "1.0"}}, "version 1.0", Fault::Unsupported},
        Spoiled{"NewerVersion", {{"/asset/minVersion", "2.1"}}, "version 2.1", Fault::Unsupported},
        Spoiled{"UnknownRequiredExtension",
                {{"/extensionsRequired", {"KHR_none_such"}}},
                "KHR_none_such",
                Fault::Unsupported},
        Spoiled{"RequiredExtensionBeforeWhatFollowsFromIt",
                {{"/extensionsRequired", {"EXT_none_such"}},
                 {"/bufferViews/0/buffer", 7},
                 {"/accessors/0/count", "none"}},
                "EXT_none_such",
                Fault::Unsupported},
        Spoiled{"VersionIsANumber", {{"/asset/version", 1.0}}, "version 1.0", Fault::Unsupported},
        Spoiled{"ObjectsOfVersion1",
                {{"/asset", nullptr}, {"/meshes", {{"mesh", json::object()}}}},
                "version 1.0",
                Fault::Unsupported},
        Spoiled{"Cycle", {{"/nodes/1/children", {0}}, {"/scenes/0/nodes", {2}}}, "is its own ancestor"},
        Spoiled{
            "OwnChild", {{"/nodes/2/children", {2}}, {"/scenes/0/nodes", {0}}}, "node 2 is its own ancestor"},
        Spoiled{"TooFar", {{"/nodes/0/scale", {2e10, 1, 1}}}, "more than 1e9 m", Fault::OutOfRange},
        Spoiled{"ScalesMultiply",
                {{"/nodes/0/scale", {1e9, 1, 1}}, {"/nodes/1/scale", {1e9, 1, 1}}},
                "node 1 'lamp' reaches further",
                Fault::OutOfRange}));

TEST(GltfHostile, RichFileIsFineBeforeItIsSpoiled) {
  const auto scene = load(rich_file());
  ASSERT_TRUE(scene.has_value()) << scene.error().what;
}

TEST(GltfHostile, LeavesOutNumbersThatAreNotFinite) {
  for (const float poison :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    GltfBuilder file = rich_file();
    std::memcpy(file.bytes().data() + 16, &poison, sizeof poison);
    EXPECT_EQ(outcome_of(load(file)),
              "refused: nothing to draw: the scene has no triangles: mesh 0 'chair', primitive 0: POSITION: "
              "accessor 0: element 1 is not finite");
  }
}

TEST(GltfHostile, LeavesOutSparseNumbersThatAreNotFinite) {
  GltfBuilder file = rich_file();
  const float poison = std::numeric_limits<float>::quiet_NaN();
  const auto at = file.json["bufferViews"][2]["byteOffset"].get<std::size_t>();
  std::memcpy(file.bytes().data() + at, &poison, sizeof poison);
  EXPECT_NE(outcome_of(load(file)).find("POSITION: accessor 0: element 2 is not finite"), std::string::npos);
}

TEST(GltfHostile, LeavesOutTrianglesWithAnIndexBeyondVertices) {
  GltfBuilder file = triangle_file();
  file.bytes()[36] = std::byte{3};
  const std::string fault = "mesh 0 'chair', primitive 0: index accessor 1: index 3 is beyond the 3 vertices";
  EXPECT_EQ(outcome_of(load(file)), "refused: nothing to draw: the scene has no triangles: " + fault);
  const json broken = file.json["meshes"][0]["primitives"][0];
  file.json["meshes"][0]["primitives"] = {broken, {{"attributes", broken["attributes"]}}, broken, broken};
  const auto scene = load(file);
  EXPECT_EQ(outcome_of(scene), "repaired: " + fault + "; its triangles are not drawn (and 2 more)");
  EXPECT_EQ(scene->triangle_count, 1u);
  for (const int mode : {4, 5, 6}) {  // of a list, a strip or a fan, the other triangles are drawn
    GltfBuilder strip;
    const auto points = strip.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
    const auto indices = strip.accessor(strip.view<std::uint8_t>({0, 1, 2, 1, 3, 255}), 5121, "SCALAR", 6);
    strip.mesh({{"attributes", {{"POSITION", points}}}, {"indices", indices}, {"mode", mode}});
    EXPECT_EQ(load(strip)->triangle_count, static_cast<std::uint64_t>(mode - 3)) << mode;
  }
}

TEST(GltfHostile, RefusesEmptyScenes) {
  GltfBuilder no_node;
  GltfBuilder no_area;
  no_area.mesh({{"attributes", {{"POSITION", no_area.positions({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}})}}}});
  for (const GltfBuilder& file : {no_node, no_area}) {
    const auto scene = load(file);
    ASSERT_FALSE(scene.has_value());
    EXPECT_NE(scene.error().what.find("nothing to draw"), std::string::npos) << scene.error().what;
  }
}

TEST(GltfHostile, DrawsAllNodesOfAFileWithoutScenes) {
  GltfBuilder file = triangle_file();
  file.json.erase("scenes");
  file.json.erase("scene");
  file.node({{"mesh", 0}, {"children", {2}}});
  file.json["nodes"].push_back({{"mesh", 0}});
  file.json.erase("scenes");
  const auto scene = load(file);
  EXPECT_EQ(outcome_of(scene), "repaired: the file has no scene; all nodes are drawn");
  EXPECT_EQ(scene->instances.size(), 3u);
}

/// One message of thousands of faults.
TEST(GltfHostile, CountsFaultsOfOneKind) {
  GltfBuilder file = triangle_file();
  for (int i = 0; i < 5000; ++i) file.node({{"mesh", i + 1}});
  EXPECT_EQ(outcome_of(load(file)), "repaired: node 1: there is no mesh 1; it goes without (and 4999 more)");
}

TEST(GltfHostile, RefusesEveryTruncation) {
  const auto whole = rich_file().glb();
  ASSERT_TRUE(load_copy(whole.data(), whole.size()).has_value());
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_FALSE(load_copy(whole.data(), size).has_value()) << size << " of " << whole.size() << " bytes";
}

TEST(GltfHostile, SurvivesFlippedBytes) {
  constexpr std::uint32_t seed = 20240607;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto whole = rich_file().glb();
  int loaded = 0;
  for (int round = 0; round < 3000; ++round) {
    auto bytes = whole;
    for (std::uint32_t flips = 1 + random() % 4; flips > 0; --flips)
      bytes[random() % bytes.size()] ^= std::byte{static_cast<std::uint8_t>(1 + random() % 255)};
    const auto scene = load_copy(bytes.data(), bytes.size());
    loaded += scene.has_value();
    ASSERT_TRUE(scene.has_value() || !scene.error().what.empty());
  }
  EXPECT_GT(loaded, 0) << "some flips change only colours";
  EXPECT_LT(loaded, 3000);
}

TEST(GltfHostile, SurvivesReplacedNumbers) {
  std::mt19937 random(7);
  const GltfBuilder whole = rich_file();
  std::vector<json::json_pointer> leaves;
  const json flat = whole.json.flatten();
  for (const auto& [pointer, value] : flat.items()) leaves.emplace_back(pointer);
  const std::vector<json> values = {
      0,  1,     2,    3,    7,  255, 65535,         std::uint32_t{1} << 31, kHuge,
      -1, 1e-40, 1e29, true, "", "x", json::array(), json::object()};
  for (const auto& leaf : leaves)
    for (const json& value : values) {
      GltfBuilder file = whole;
      file.json[leaf] = value;
      const auto scene = load(file);
      ASSERT_TRUE(scene.has_value() || !scene.error().what.empty()) << leaf;
    }
}

TEST(GltfHostile, RefusesDeepJsonAtOnce) {
  const std::string depth(30000, '[');
  const auto file = bytes_of_text("{\"asset\":{\"version\":\"2.0\"},\"extras\":" + depth + "}");
  const auto scene = load_copy(file.data(), file.size());
  ASSERT_FALSE(scene.has_value());
  EXPECT_NE(scene.error().what.find("deeper than 128"), std::string::npos) << scene.error().what;
}

TEST(GltfHostile, RefusesDeepNodes) {
  GltfBuilder file = triangle_file();
  for (int i = 1; i <= 300; ++i) {
    file.json["nodes"].push_back(json::object());
    file.json["nodes"][static_cast<std::size_t>(i) - 1]["children"] = {i};
  }
  const auto scene = load(file);
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().what, "node 256 is nested deeper than 256 levels");
}

/// A few kilobytes that would need terabytes: very many accessors and primitives read one buffer view.
TEST(GltfHostile, RefusesWorkOutOfProportionBeforeItIsDone) {
  GltfBuilder file = triangle_file();
  file.json["accessors"][0].erase("bufferView");
  file.json["accessors"][0]["count"] = 4'000'000;
  for (int i = 0; i < 500; ++i)
    file.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
  const auto scene = load(file);
  ASSERT_FALSE(scene.has_value());
  EXPECT_NE(scene.error().what.find("primitive 1: more vertices than a file of this size"), std::string::npos)
      << scene.error().what;
}

TEST(GltfHostile, RefusesManyLights) {
  GltfBuilder file = triangle_file();
  const json shines = file.light({{"type", "point"}});
  for (int i = 0; i < 257; ++i) file.node({{"extensions", shines}});
  const auto scene = load(file);
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().what, "257 lights, at most 256 can be told apart");
}

TEST(GltfHostile, DrawsTheColourInsteadOfDamagedImages) {
  for (const auto& image : {make_noise_png({8, 8}), make_jpeg({8, 8}, JpegKind::Colour)}) {
    GltfBuilder file = rich_file();
    const auto half =
        std::vector<std::byte>(image.begin(), image.begin() + static_cast<std::ptrdiff_t>(image.size() / 2));
    file.json["images"][0]["bufferView"] = file.view(half);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.25, 0, 1};
    const auto scene = load(file);
    EXPECT_EQ(outcome_of(scene).rfind("repaired: image 0: ", 0), 0u) << outcome_of(scene);
    EXPECT_FALSE(scene->materials.at(0).texture);
    EXPECT_EQ(scene->materials[0].base_color, glm::vec4(0.5f, 0.25f, 0, 1));
  }
}

TEST(GltfHostile, DecodesNoImagesAboveTheLimit) {
  const auto bytes = rich_file().glb();
  SceneLimits limits;
  limits.image_pixels = 15;
  const auto scene = load_scene_from_memory(bytes, {}, limits);
  EXPECT_NE(outcome_of(scene).find("image 0: picture of 4x4 pixels is over the limit"), std::string::npos);
  EXPECT_TRUE(scene->textures.empty());
}

/// Images of one colour that share one small file, each below the limit of an image.
TEST(GltfHostile, LeavesOutManyLargeImagesInAFewBytes) {
  const std::vector<std::byte> image = make_png({256, 256}, 8, 0, {});
  SceneLimits limits;
  limits.image_pixels = 256 * 256;
  const auto with_images = [&](int images) {
    GltfBuilder file = rich_file();
    const auto view = file.view(image);
    file.view(std::vector<std::byte>(100'000));  // bytes that are of no image earn nothing
    json& primitives = file.json["meshes"][0]["primitives"];
    const json primitive = primitives[0];
    for (const char* list : {"images", "textures", "materials"}) file.json[list] = json::array();
    primitives = json::array();
    for (int i = 0; i < images; ++i) {
      file.json["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
      file.json["textures"].push_back({{"source", i}});
      file.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
      primitives.push_back(primitive);
      primitives.back()["material"] = i;
    }
    return load_scene_from_memory(file.glb(), {}, limits);
  };
  const auto one = with_images(1), two = with_images(2);
  EXPECT_EQ(outcome_of(one), "drawn");
  EXPECT_NE(outcome_of(two).find("image 1: picture of 256x256 pixels is over the limit"), std::string::npos);
  EXPECT_EQ(two->textures.size(), 1u);
  limits.all_image_pixels = 256 * 256 - 1;
  EXPECT_TRUE(with_images(1)->textures.empty());
}

/// A damaged image takes as much time as others. So after some, images must be as large as their files allow.
TEST(GltfHostile, DecodesFewDamagedImagesOfOneColour) {
  const auto with_damaged = [](int damaged) {
    GltfBuilder file = rich_file();
    std::vector<std::byte> half = make_noise_png({8, 8});
    half.resize(half.size() / 2);
    const auto broken = file.view(half), plain = file.view(make_png({256, 256}, 8, 0, {}));
    json& primitives = file.json["meshes"][0]["primitives"];
    const json primitive = primitives[0];
    for (const char* list : {"images", "textures", "materials"}) file.json[list] = json::array();
    primitives = json::array();
    for (int i = 0; i <= damaged; ++i) {
      file.json["images"].push_back({{"bufferView", i < damaged ? broken : plain}});
      file.json["textures"].push_back({{"source", i}});
      file.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
      primitives.push_back(primitive);
      primitives.back()["material"] = i;
    }
    return load(file)->textures.size();
  };
  EXPECT_EQ(with_damaged(7), 1u);
  EXPECT_EQ(with_damaged(8), 0u);
}

TEST(GltfHostile, ReadsNoBuffersWithoutBytes) {
  GltfBuilder second = triangle_file();
  second.json["buffers"].push_back({{"byteLength", 36}});
  GltfBuilder none = triangle_file();
  const auto text = bytes_of_text(none.json.dump());
  const auto with_two = load(second);
  const auto without_bin = load_copy(text.data(), text.size());
  EXPECT_EQ(outcome_of(with_two), "drawn") << "nobody reads the second";
  ASSERT_FALSE(without_bin.has_value());
  EXPECT_NE(without_bin.error().what.find("buffer 0: it has neither a URI nor a GLB's binary chunk"),
            std::string::npos)
      << without_bin.error().what;
}

TEST(GltfHostile, RefusesMoreObjectsThanItsSizeAllows) {
  GltfBuilder file = triangle_file();
  file.json["materials"] = json::array_t(100'000, json::object());
  const auto scene = load(file);
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().fault, Fault::OutOfRange);
  EXPECT_EQ(scene.error().what, "more objects than a file of this size should have");
  file.json["materials"] = json::array_t(100'000, json{{"name", std::string(100, 'm')}});
  EXPECT_TRUE(load(file).has_value());
}

TEST(GltfHostile, RefusesInstancesWhoseNamesAreLong) {
  const auto with_name = [](std::size_t letters) {
    GltfBuilder file = triangle_file();
    file.json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 50'000}});
    json& node = file.json["nodes"][0];
    node["name"] = std::string(letters, 'n');
    node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
        file.json["accessors"].size() - 1;
    return load(file);
  };
  EXPECT_TRUE(with_name(10));
  const auto scene = with_name(20'000);
  ASSERT_FALSE(scene.has_value());
  EXPECT_NE(scene.error().what.find("50000 instances are more than"), std::string::npos)
      << scene.error().what;
}

}  // namespace
}  // namespace farshade
