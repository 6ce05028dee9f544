/// The external files and data URIs of a scene.
#include <gtest/gtest.h>
#include <sodium/utils.h>
#include <sys/stat.h>

#include "stereo/base/files.h"
#include "stereo/gltf/gltf_files.h"
#include "tests/unit/gltf/gltf_builder.h"
#include "tests/unit/image/image_files.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// triangle_file() with its buffer at `uri`.
std::vector<std::byte> with_external_buffer(const std::string& uri) {
  GltfBuilder file = triangle_file();
  file.json["buffers"][0]["uri"] = uri;
  return bytes_of_text(file.json.dump());
}

class SceneFiles : public testing::Test {
 protected:
  SceneFiles() {
    fs::create_directories(folder_ / "sub dir");
    const auto buffer = triangle_file().bytes();
    for (const char* name : {"scene/triangle.bin", "scene/sub dir/triangle.bin", "scene/a+b.bin",
                             "scene/50%.bin", "outside.bin"})
      EXPECT_TRUE(write_file_atomically(scratch_.path() / name, buffer));
  }
  Expected<Scene> load_with(const std::string& uri) {
    EXPECT_TRUE(write_file_atomically(folder_ / "scene.gltf", with_external_buffer(uri)));
    return load_scene(folder_ / "scene.gltf");
  }
  std::string refusal_of(const std::string& uri) {
    const auto scene = load_with(uri);
    return scene ? "loaded" : scene.error().what;
  }
  ScratchFolder scratch_;
  fs::path folder_ = scratch_.path() / "scene";
};

TEST_F(SceneFiles, OpensFilesInsideTheFolder) {
  for (const char* uri : {"triangle.bin", "./triangle.bin", "sub%20dir/triangle.bin", "triangle.bi%6e",
                          "a+b.bin", "a%2Bb.bin", "50%.bin", "50%25.bin"}) {
    const auto scene = load_with(uri);
    ASSERT_TRUE(scene.has_value()) << uri << ": " << scene.error().what;
    EXPECT_EQ(scene->triangle_count, 1u);
    EXPECT_EQ(scene->name, "scene.gltf");
  }
}

TEST_F(SceneFiles, ListsWhatItReadIfItIsAskedTo) {
  ASSERT_TRUE(load_with("./sub%20dir/triangle.bin"));
  const fs::path path = folder_ / "scene.gltf";
  EXPECT_TRUE(load_scene(path)->files.empty()) << "hashing takes time";
  const Scene scene = load_scene(path, {}, {}, ListFiles::Yes).value();
  ASSERT_EQ(scene.files.size(), 2u);
  EXPECT_EQ(scene.files[0].name, "scene.gltf");
  EXPECT_EQ(scene.files[1].name, "sub dir/triangle.bin");
  for (const SceneFile& file : scene.files) {
    const auto bytes = read_file(folder_ / file.name, 1 << 20).value();
    EXPECT_EQ(file.bytes, bytes.size());
    EXPECT_EQ(file.digest, digest_of(bytes));
    EXPECT_EQ(file.changed_ns, changed_at(folder_ / file.name));
    EXPECT_GT(file.changed_ns, 0);
  }
}

TEST_F(SceneFiles, RefusesWhatLeavesTheFolder) {
  fs::create_symlink(scratch_.path() / "outside.bin", folder_ / "link.bin");
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("sub%20dir/../../outside.bin"),
        std::string("%2e%2e/outside.bin"), (scratch_.path() / "outside.bin").string(),
        "file://" + (scratch_.path() / "outside.bin").string(), std::string("link.bin")}) {
    const std::string what = refusal_of(uri);
    EXPECT_NE(what.find("scene's folder"), std::string::npos) << uri << ": " << what;
  }
}

TEST_F(SceneFiles, RefusesWhatIsNoFile) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  for (const char* uri : {"sub%20dir", "pipe", ".", "missing.bin", "a%00b", "", "%zz", "a%2"}) {
    const std::string what = refusal_of(uri);
    EXPECT_NE(what.find("external file '"), std::string::npos) << uri << ": " << what;
  }
}

TEST_F(SceneFiles, MayHaveMoreBytesThanTheirBuffer) {
  auto bytes = triangle_file().bytes();
  bytes.resize(bytes.size() + 1000, std::byte{7});
  EXPECT_TRUE(write_file_atomically(folder_ / "triangle.bin", bytes));
  const auto scene = load_with("triangle.bin");
  EXPECT_EQ(outcome_of(scene), "drawn");
  EXPECT_EQ(scene->hash, load(triangle_file())->hash);
}

/// What lies in the bytes that are there is drawn.
TEST_F(SceneFiles, MayHaveFewerBytesThanTheirBuffer) {
  GltfBuilder file = triangle_file();
  const auto later = file.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  file.mesh({{"attributes", {{"POSITION", later}}}});
  file.json["buffers"][0]["uri"] = "triangle.bin";
  EXPECT_TRUE(write_file_atomically(folder_ / "scene.gltf", bytes_of_text(file.json.dump())));
  const auto scene = load_scene(folder_ / "scene.gltf");
  EXPECT_EQ(outcome_of(scene),
            "repaired: mesh 1 'chair', primitive 0: POSITION: accessor 2: buffer 0: its data has 42 bytes, "
            "byteLength is 80; it is not drawn");
  EXPECT_EQ(scene->triangle_count, 1u);
}

TEST_F(SceneFiles, RefusesBufferOfOtherLength) {
  EXPECT_TRUE(write_file_atomically(folder_ / "triangle.bin", bytes_of_text("short")));
  EXPECT_NE(refusal_of("triangle.bin").find("buffer 0: its data has 5 bytes, byteLength is"),
            std::string::npos);
  EXPECT_TRUE(write_file_atomically(folder_ / "triangle.bin", std::string_view()));
  EXPECT_NE(refusal_of("triangle.bin").find("it is empty"), std::string::npos);
}

/// The buffer of triangle_file() as base64. Its length is a multiple of 3, so that it needs no padding.
std::string triangle_base64() {
  const auto bytes = triangle_file().bytes();
  std::string text(sodium_base64_encoded_len(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                    bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();  // the terminating zero
  return text;
}

TEST_F(SceneFiles, DecodesDataUris) {
  for (const std::string media : {"application/octet-stream", "application/gltf-buffer", ""}) {
    const auto scene = load_with("data:" + media + ";base64," + triangle_base64());
    ASSERT_TRUE(scene.has_value()) << media << ": " << scene.error().what;
    EXPECT_EQ(scene->hash, load(triangle_file())->hash);
  }
}

TEST_F(SceneFiles, DecodesDataUrisInCapitalsAndWithEscapes) {
  std::string escaped;
  for (const char c : triangle_base64()) escaped += c == 'A' ? "%41" : std::string(1, c);
  const auto scene = load_with("DATA:;Base64," + escaped);
  ASSERT_TRUE(scene.has_value()) << scene.error().what;
  EXPECT_EQ(scene->hash, load(triangle_file())->hash);
}

TEST_F(SceneFiles, RefusesDamagedDataUris) {
  const std::string good = triangle_base64(), head = "data:application/octet-stream;base64,";
  std::string bad_letter = good;
  bad_letter[5] = '*';
  for (const auto& [uri, says] :
       {std::pair<std::string, std::string>{head + bad_letter, "the base64 text of a data URI is damaged"},
        {head + good.substr(0, 8), "its data has 6 bytes"},
        {head + good.substr(0, 8) + "AA==", "its data has 7 bytes"},
        {head + good.substr(0, 8) + "AA", "its data has 7 bytes"},
        {head + good.substr(0, 8) + "A", "is damaged"},
        {head + good + "====", "is damaged"},
        {head, "a data URI is empty"},
        {"data:text/html,x", "a data URI is not base64"},
        {"data:;base64", "a data URI is not base64"}}) {
    const std::string what = refusal_of(uri);
    EXPECT_NE(what.find(says), std::string::npos) << uri << ": " << what;
  }
}

TEST_F(SceneFiles, DrawsTheColourInsteadOfADamagedImageDataUri) {
  GltfBuilder file = rich_file();
  file.json["images"][0] = {{"name", "weave"}, {"uri", "data:image/png;base64,*"}};
  EXPECT_EQ(outcome_of(load_scene_from_memory(file.glb())),
            "repaired: image 0 'weave': the base64 text of a data URI is damaged; the base colour factor is "
            "drawn");
}

TEST(SceneInMemory, MayHaveABufferLongerThanTheBinaryChunkOfWhichTheRestIsNotRead) {
  GltfBuilder file = triangle_file();
  file.json["buffers"][0]["byteLength"] = 1000;
  EXPECT_EQ(outcome_of(load_scene_from_memory(file.glb())), "drawn");
}

TEST_F(SceneFiles, HoldsTheByteLimit) {
  EXPECT_TRUE(write_file_atomically(folder_ / "scene.gltf", with_external_buffer("triangle.bin")));
  SceneLimits limits;
  limits.external_bytes = 10;
  EXPECT_FALSE(load_scene(folder_ / "scene.gltf", limits).has_value());
  limits.external_bytes = 1000;
  EXPECT_TRUE(load_scene(folder_ / "scene.gltf", limits).has_value());
  limits.file_bytes = 10;
  EXPECT_FALSE(load_scene(folder_ / "scene.gltf", limits).has_value());
}

TEST_F(SceneFiles, FindsExternalImages) {
  GltfBuilder file = rich_file();
  file.json["images"][0] = {{"name", "weave"}, {"uri", "weave.png"}};
  EXPECT_TRUE(write_file_atomically(folder_ / "rich.glb", file.glb()));
  const auto without = load_scene(folder_ / "rich.glb");
  EXPECT_NE(outcome_of(without).find("repaired: image 0 'weave': external file 'weave.png'"),
            std::string::npos)
      << outcome_of(without);
  EXPECT_TRUE(without->textures.empty());
  EXPECT_TRUE(write_file_atomically(folder_ / "weave.png", make_noise_png({4, 4})));
  const auto with = load_scene(folder_ / "rich.glb");
  ASSERT_TRUE(with.has_value()) << with.error().what;
  EXPECT_EQ(with->textures.at(0).image.size, (Extent{4, 4}));
}

TEST_F(SceneFiles, RefusesDirectoriesAndMissingScenes) {
  EXPECT_EQ(load_scene(folder_ / "none.glb").error().fault, Fault::Missing);
  EXPECT_FALSE(load_scene(folder_).has_value());
  EXPECT_FALSE(load_scene("").has_value());
}

TEST(SceneInMemory, OpensNoFiles) {
  const auto bytes = with_external_buffer("triangle.bin");
  const auto scene = load_scene_from_memory(bytes);
  ASSERT_FALSE(scene.has_value());
  EXPECT_NE(scene.error().what.find("has no folder"), std::string::npos) << scene.error().what;
}

TEST(JsonDepth, CountsBracketsOutsideOfStrings) {
  EXPECT_TRUE(gltf::check_json_depth(R"({"a":[[]],"b":"[[[[\"[[[["})", 3).has_value());
  EXPECT_FALSE(gltf::check_json_depth(R"({"a":[[[]]]})", 3).has_value());
  EXPECT_TRUE(gltf::check_json_depth("]]]][[[", 3).has_value());
}

TEST(Container, RefusesBrokenGlb) {
  const auto whole = triangle_file().glb();
  const auto refusal_with = [&](std::size_t at, std::uint8_t value) {
    auto bytes = whole;
    bytes[at] = std::byte{value};
    const auto opened = gltf::open_container(bytes);
    return opened ? "opened" : opened.error().what;
  };
  EXPECT_EQ(refusal_with(4, 3), "GLB: version 3, only 2 is read");
  EXPECT_NE(refusal_with(15, 255).find("a chunk says"), std::string::npos);
  EXPECT_NE(refusal_with(16, 0).find("not JSON"), std::string::npos);
  EXPECT_EQ(refusal_with(0, 'G'), "neither a GLB nor a glTF JSON text");
}

TEST(Container, IsRepaired) {
  const auto outcome = [](const std::vector<std::byte>& bytes) {
    return outcome_of(load_scene_from_memory(bytes));
  };
  auto glb = triangle_file().glb();
  const std::string length = std::to_string(glb.size());
  glb.resize(glb.size() + 20, std::byte{0xff});
  EXPECT_EQ(outcome(glb), "repaired: GLB: the header says " + length + " bytes, the file has " +
                              std::to_string(glb.size()) + "; it is read all the same");
  auto short_header = triangle_file().glb();
  short_header[8] = std::byte{20};
  EXPECT_NE(outcome(short_header).find("repaired: GLB: the header says"), std::string::npos);

  const std::vector<std::byte> text = triangle_file().gltf();
  auto marked = bytes_of_text("\xef\xbb\xbf");
  marked.insert(marked.end(), text.begin(), text.end());
  EXPECT_EQ(outcome(marked), "repaired: the JSON text begins with a byte order mark; it is skipped");
  auto zeros = text;
  zeros.resize(zeros.size() + 3);
  EXPECT_EQ(outcome(zeros), "repaired: the JSON text ends with zero bytes; they are skipped");
  std::vector<std::byte> wide = bytes_of_text("\xff\xfe");
  for (const std::byte b : text) wide.insert(wide.end(), {b, std::byte{0}});
  EXPECT_EQ(outcome(wide), "refused: the JSON text is UTF-16: save it as UTF-8");
}

TEST(Container, MayHaveChunksThatEndAnywhere) {
  GltfBuilder file = triangle_file();
  const std::string words = file.json.dump() + std::string((5 - file.json.dump().size() % 4) % 4, ' ');
  std::vector<std::byte> glb = bytes_of_text("glTF");
  const auto put = [&](std::size_t value) {
    for (int i = 0; i < 4; ++i) glb.push_back(static_cast<std::byte>(value >> 8 * i & 0xff));
  };
  const auto put_bytes = [&](const std::vector<std::byte>& bytes) {
    glb.insert(glb.end(), bytes.begin(), bytes.end());
  };
  put(2);
  put(28 + words.size() + file.bytes().size());
  put(words.size());
  put_bytes(bytes_of_text("JSON" + words));
  put(file.bytes().size());
  put(0x004E4942);
  put_bytes(file.bytes());
  const auto scene = load_scene_from_memory(glb);
  EXPECT_EQ(
      outcome_of(scene),
      "repaired: GLB: a chunk does not end at a multiple of 4 bytes; it is read all the same (and 1 more)");
  EXPECT_EQ(scene->hash, load(file)->hash);
}

}  // namespace
}  // namespace farshade
