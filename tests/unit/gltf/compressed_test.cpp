/// Files with compressed buffers: they make the same scene as the plain file, and hostile ones are refused
/// before anything large is allocated.
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "tests/support/gltf_compressor.h"
#include "tests/unit/gltf/gltf_builder.h"

namespace farshade {
namespace {

using nlohmann::json;

Expected<Scene> load(const std::vector<std::byte>& file) {
  return load_copy(file.data(), file.size());
}

/// A grid of n x n quads over the unit square, indexed, with normals.
GltfBuilder grid_file(std::uint32_t n) {
  GltfBuilder file;
  std::vector<glm::vec3> points;
  for (std::uint32_t y = 0; y <= n; ++y)
    for (std::uint32_t x = 0; x <= n; ++x)
      points.emplace_back(static_cast<float>(x) / 8, static_cast<float>(y) / 8,
                          static_cast<float>(x * y % 3));
  std::vector<std::uint32_t> corners;
  for (std::uint32_t y = 0; y < n; ++y)
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x, c = a + n + 1;
      corners.insert(corners.end(), {a, a + 1, c, c, a + 1, c + 1});
    }
  const auto normals = std::vector<glm::vec3>(points.size(), {0, 0, 1});
  const auto positions = file.positions(points), normal = file.positions(normals);
  const auto indices = file.accessor(file.view(corners), 5125, "SCALAR", corners.size());
  file.mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normal}}}, {"indices", indices}});
  return file;
}

/// A triangle whose view of positions is replaced by `encoded` bytes of meshoptimizer. `more` changes the
/// extension.
GltfBuilder encoded_file(const std::vector<unsigned char>& encoded, json more) {
  GltfBuilder file = triangle_file();
  const auto view = file.view(encoded);
  json extension{{"buffer", 0},
                 {"byteOffset", file.json["bufferViews"][view]["byteOffset"]},
                 {"byteLength", encoded.size()},
                 {"byteStride", 12},
                 {"count", 3},
                 {"mode", "ATTRIBUTES"}};
  if (!more.empty()) extension.update(more);
  file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = extension;
  return file;
}

std::vector<unsigned char> encoded_vertices(const void* vertices, std::size_t count, std::size_t stride) {
  std::vector<unsigned char> bytes(meshopt_encodeVertexBufferBound(count, stride));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), vertices, count, stride));
  return bytes;
}

std::vector<unsigned char> encoded_triangle() {
  const std::vector<glm::vec3> points{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  return encoded_vertices(points.data(), points.size(), sizeof(glm::vec3));
}

GltfBuilder encoded_triangle_file(const json& more) {
  return encoded_file(encoded_triangle(), more);
}

TEST(Meshopt, MakesTheSameSceneAsThePlainFile) {
  for (const GltfBuilder& file : {triangle_file(), rich_file(), grid_file(40)}) {
    const auto plain = file.glb(), packed = compress_with_meshopt(plain);
    const auto scene = load(packed);
    ASSERT_TRUE(scene) << scene.error().what;
    EXPECT_EQ(scene->hash, load(plain)->hash);
  }
}

TEST(Meshopt, ReadsTrianglesInTheCodecForTriangles) {
  const auto plain = grid_file(40).glb(), packed = compress_with_meshopt(plain, IndexCodec::Triangles);
  EXPECT_LT(packed.size(), plain.size() / 4);
  const auto scene = load(packed);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->triangle_count, 3200u);
  EXPECT_EQ(scene->meshes[0].positions, load(plain)->meshes[0].positions);
}

TEST(Meshopt, IsReadByItsNewerName) {
  GltfBuilder file = encoded_triangle_file({});
  json& extensions = file.json["bufferViews"][0]["extensions"];
  extensions = {{"KHR_meshopt_compression", extensions["EXT_meshopt_compression"]}};
  file.json["extensionsRequired"] = {"KHR_meshopt_compression"};
  const auto scene = load(file);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->meshes[0].positions[1], glm::vec3(2, 0, 0));
}

TEST(Meshopt, UndoesItsFilters) {
  std::vector<float> numbers{0, 0, 0, 3, 0, 0, 0, 3, 0.5f};
  std::vector<std::uint32_t> packed(9);
#if MESHOPTIMIZER_VERSION >= 190  // before, each vector has one exponent
  meshopt_encodeFilterExp(packed.data(), 3, 12, 20, numbers.data(), meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(packed.data(), 3, 12, 20, numbers.data());
#endif
  const auto exponential =
      load(encoded_file(encoded_vertices(packed.data(), 3, 12), {{"filter", "EXPONENTIAL"}}));
  ASSERT_TRUE(exponential) << exponential.error().what;
  EXPECT_EQ(exponential->meshes[0].positions[2], glm::vec3(0, 3, 0.5f));

  const std::vector<glm::vec4> directions(3, {0.6f, 0, 0.8f, 0});
  std::vector<std::uint8_t> octahedral(12);
  meshopt_encodeFilterOct(octahedral.data(), 3, 4, 8, &directions[0].x);
  GltfBuilder file = triangle_file();
  const auto encoded = encoded_vertices(octahedral.data(), 3, 4);
  const auto source = file.view(encoded), view = file.view(std::vector<std::uint8_t>(12));
  const auto normals = file.accessor(view, 5120, "VEC3", 3, {{"normalized", true}});
  file.json["bufferViews"][view]["byteStride"] = 4;
  file.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0},
      {"byteOffset", file.json["bufferViews"][source]["byteOffset"]},
      {"byteLength", encoded.size()},
      {"byteStride", 4},
      {"count", 3},
      {"mode", "ATTRIBUTES"},
      {"filter", "OCTAHEDRAL"}};
  file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals;
  const auto scene = load(file);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_LT(glm::length(scene->meshes[0].normals[0] - glm::vec3(0.6f, 0, 0.8f)), 0.02f);
}

TEST(Meshopt, FallbackBuffersAreNotRead) {
  GltfBuilder file = encoded_triangle_file({});
  file.json["buffers"].push_back({{"byteLength", 36},
                                  {"uri", "none.bin"},
                                  {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  file.json["bufferViews"][0]["buffer"] = 1;
  EXPECT_TRUE(load(file));
  file.json["bufferViews"][0].erase("extensions");
  EXPECT_NE(load(file).error().what.find("buffer view 0 reads beyond its buffer (0 bytes)"),
            std::string::npos);
}

/// Legal, if all its views are compressed: nothing reads the buffer.
TEST(Meshopt, FallbackBuffersNeedNotSayThatTheyAre) {
  GltfBuilder file = encoded_triangle_file({});
  file.json["buffers"].push_back({{"byteLength", 36}});
  file.json["bufferViews"][0]["buffer"] = 1;
  EXPECT_EQ(outcome_of(load(file)), "drawn");
}

struct Wrong {
  json extension;
  const char* says;
  Fault fault = Fault::Malformed;
};

TEST(Meshopt, RefusesSizesBeforeItDecodes) {
  constexpr auto kHuge = (std::uint64_t{1} << 31) - 1;
  const std::vector<Wrong> wrong{
      {{{"count", kHuge}}, "compressed buffer view 0 decodes to 2147483647 elements"},
      {{{"count", kHuge + 1}}, "count should be a whole number from 1 to 2147483647"},
      {{{"count", 4}}, "compressed buffer view 0 decodes to 4 elements of 12 bytes, but its length is 36"},
      {{{"count", 0}}, "count should be a whole number from 1"},
      {{{"byteStride", 260}}, "do not fit each other"},
      {{{"byteStride", 6}}, "do not fit each other"},
      {{{"mode", "TRIANGLES"}}, "do not fit each other"},
      {{{"mode", "POINTS"}}, "mode 'POINTS'"},
      {{{"filter", "OCTAHEDRAL"}}, "filter 'OCTAHEDRAL', stride 12"},
      {{{"filter", "COLOR"}}, "filter 'COLOR'"},
      {{{"buffer", 7}}, "there is no buffer 7"},
      {{{"byteOffset", kHuge}}, "reads beyond its buffer"},
      {{{"byteLength", kHuge}}, "reads beyond its buffer"},
      {{{"byteLength", 20}}, "its compressed bytes are damaged"}};
  ASSERT_TRUE(load(encoded_triangle_file({})));
  for (const Wrong& one : wrong) {
    const auto scene = load(encoded_triangle_file(one.extension));
    ASSERT_FALSE(scene) << one.extension;
    EXPECT_NE(scene.error().what.find(one.says), std::string::npos) << scene.error().what;
    EXPECT_EQ(scene.error().fault, one.fault);
  }
}

TEST(Meshopt, RefusesMoreThanItsBytesCanHold) {
  GltfBuilder file = encoded_triangle_file({{"count", 1 << 20}});
  file.json["bufferViews"][0]["byteLength"] = 12 << 20;
  EXPECT_NE(load(file).error().what.find("bytes are too few for 12582912"), std::string::npos)
      << load(file).error().what;
}

TEST(Meshopt, RefusesManyViewsOfTheSameBytes) {
  const std::vector<glm::vec4> zeros(1 << 16);
  const auto encoded = encoded_vertices(zeros.data(), zeros.size(), 16);
  GltfBuilder file = encoded_file(encoded, {{"count", 1 << 16}, {"byteStride", 16}});
  file.json["bufferViews"][0]["byteLength"] = 16 << 16;
  ASSERT_NE(load(file).error().what.find("nothing to draw"), std::string::npos) << "all is decoded";
  for (int i = 0; i < 200; ++i) file.json["bufferViews"].push_back(file.json["bufferViews"][0]);
  const auto scene = load(file);
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().fault, Fault::OutOfRange) << scene.error().what;
}

TEST(Meshopt, SaysHowToCureTheNewerFormat) {
  auto encoded = encoded_triangle();
  encoded[0] = 0xa1;
  const auto scene = load(encoded_file(encoded, {}));
  EXPECT_NE(scene.error().what.find("version 1 of its format"), std::string::npos) << scene.error().what;
}

TEST(Draco, SequentialMakesTheSameSceneAsThePlainFile) {
  for (const GltfBuilder& file : {triangle_file(), grid_file(40)}) {
    const auto plain = file.glb();
    const auto scene = load(compress_with_draco(plain));
    ASSERT_TRUE(scene) << scene.error().what;
    EXPECT_EQ(scene->hash, load(plain)->hash);
  }
}

TEST(Draco, EdgebreakerMakesTheSameTrianglesInAnotherOrder) {
  const auto plain = load(grid_file(40).glb()).value();
  const auto scene = load(compress_with_draco(grid_file(40).glb(), DracoMethod::Edgebreaker));
  ASSERT_TRUE(scene) << scene.error().what;
  const auto corners = [](const Scene& of) {
    std::multiset<std::array<float, 3>> all;
    for (const glm::uvec3& t : of.meshes[0].triangles)
      for (const std::uint32_t v : {t.x, t.y, t.z}) {
        const glm::vec3 p = of.meshes[0].positions[v];
        all.insert({p.x, p.y, p.z});
      }
    return all;
  };
  EXPECT_EQ(corners(*scene), corners(plain));
}

/// A Draco file of a grid whose JSON `change` changes.
template <class Change>
Error refused_draco(DracoMethod method, Change change) {
  const auto glb = compress_with_draco(grid_file(8).glb(), method);
  std::uint32_t text_bytes = 0;
  std::memcpy(&text_bytes, glb.data() + 12, 4);
  const auto* first = reinterpret_cast<const char*>(glb.data());
  GltfBuilder file;
  file.json = json::parse(first + 20, first + 20 + text_bytes);
  file.bytes().assign(glb.begin() + 28 + text_bytes, glb.end());
  change(file);
  const auto scene = load(file);
  return scene ? Error{} : scene.error();
}

std::size_t draco_start(GltfBuilder& file) {
  return file.json["bufferViews"].back()["byteOffset"].get<std::size_t>();
}

TEST(Draco, RefusesCountsBeforeItDecodes) {
  for (const DracoMethod method : {DracoMethod::Sequential, DracoMethod::Edgebreaker}) {
    const Error other =
        refused_draco(method, [](GltfBuilder& file) { file.json["accessors"][2]["count"] = 30; });
    EXPECT_NE(other.what.find("has 128 triangles, its accessor 10"), std::string::npos) << other.what;
  }
  // Both the JSON and the Draco header say 2^28 triangles (a varint of five bytes, over what follows it).
  const Error huge = refused_draco(DracoMethod::Sequential, [](GltfBuilder& file) {
    const std::size_t at = draco_start(file) + 11;
    for (const std::size_t i : {0u, 1u, 2u, 3u}) file.bytes()[at + i] = std::byte{0x80};
    file.bytes()[at + 4] = std::byte{0x01};
    file.json["accessors"][2]["count"] = 3u << 28;
  });
  EXPECT_EQ(huge.fault, Fault::OutOfRange) << huge.what;
  EXPECT_NE(huge.what.find("more bytes than a file of this size"), std::string::npos) << huge.what;
}

TEST(Draco, RefusesWhatDoesNotFitThePrimitive) {
  const auto says = [](const char* text, auto change) {
    const Error error = refused_draco(DracoMethod::Edgebreaker, change);
    EXPECT_NE(error.what.find(text), std::string::npos) << error.what;
    EXPECT_NE(error.what.find("the Draco mesh of mesh 0 'chair', primitive 0"), std::string::npos)
        << error.what;
  };
  const auto extension = [](GltfBuilder& file) -> json& {
    return file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
  };
  says("there is no buffer view 99", [&](GltfBuilder& file) { extension(file)["bufferView"] = 99; });
  says("POSITION is not in the mesh",
       [&](GltfBuilder& file) { extension(file)["attributes"]["POSITION"] = 99; });
  says("does not have the mesh's 81 vertices",
       [](GltfBuilder& file) { file.json["accessors"][0]["count"] = 80; });
  says("does not have the mesh's 81 vertices",
       [](GltfBuilder& file) { file.json["accessors"][0]["type"] = "VEC4"; });
  says("should have triangles with indices",
       [](GltfBuilder& file) { file.json["meshes"][0]["primitives"][0].erase("indices"); });
  says("is no mesh of Draco", [](GltfBuilder& file) { file.bytes()[draco_start(file)] = std::byte{'X'}; });
  says("only 2.2 is read", [](GltfBuilder& file) { file.bytes()[draco_start(file) + 6] = std::byte{1}; });
}

TEST(Draco, LeavesOutWhatThePrimitiveDoesNotAskFor) {
  const Error error = refused_draco(DracoMethod::Sequential, [](GltfBuilder& file) {
    file.json["meshes"][0]["primitives"][0]["attributes"].erase("NORMAL");
  });
  EXPECT_EQ(error.what, "");
}

TEST(Compressed, SurvivesEveryFlippedByteAndTruncation) {
  for (auto glb : {compress_with_meshopt(grid_file(3).glb()),
                   compress_with_meshopt(grid_file(3).glb(), IndexCodec::Triangles),
                   compress_with_draco(grid_file(3).glb()),
                   compress_with_draco(grid_file(3).glb(), DracoMethod::Edgebreaker)}) {
    std::uint32_t text_bytes = 0;
    std::memcpy(&text_bytes, glb.data() + 12, 4);
    ASSERT_TRUE(load(glb));
    for (std::size_t i = 28 + text_bytes; i < glb.size(); ++i)
      for (const std::byte flip : {std::byte{1}, std::byte{0x80}, std::byte{0xff}}) {
        glb[i] ^= flip;
        if (const auto scene = load(glb); !scene) {
          EXPECT_EQ(scene.error().what.find('\n'), std::string::npos);
        }
        glb[i] ^= flip;
      }
  }
}

}  // namespace
}  // namespace farshade
