#include "stereo/lod/level_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <thread>

#include "stereo/base/files.h"
#include "tests/unit/lod/shapes.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

Scene small_scene(std::uint32_t seed = 1) {
  Scene scene;
  scene.materials.emplace_back();
  scene.meshes.push_back(bumpy_sphere(seed));
  scene.meshes.emplace_back();
  scene.triangle_count = scene.meshes[0].triangles.size();
  scene.hash[0] = static_cast<std::uint8_t>(seed);
  return scene;
}

bool same(const SceneLevels& a, const SceneLevels& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].triangles != b[i].triangles || a[i].levels.size() != b[i].levels.size()) return false;
    for (std::size_t k = 0; k < a[i].levels.size(); ++k)
      if (a[i].levels[k].first != b[i].levels[k].first || a[i].levels[k].count != b[i].levels[k].count ||
          a[i].levels[k].error != b[i].levels[k].error)
        return false;
  }
  return true;
}

class LevelCache : public testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path folder() const { return folder_.path() / "cache"; }
  ScratchFolder folder_;
  Scene scene_ = small_scene();
};

TEST_F(LevelCache, KeepsWhatWasMade) {
  const CachedLevels made = cached_levels(scene_, folder());
  EXPECT_FALSE(made.from_file);
  EXPECT_EQ(made.trouble, "");
  EXPECT_TRUE(same(made.levels, make_levels(scene_)));
  const CachedLevels read = cached_levels(scene_, folder());
  EXPECT_TRUE(read.from_file);
  EXPECT_TRUE(same(read.levels, made.levels));
}

TEST_F(LevelCache, KeepsScenesApart) {
  static_cast<void>(cached_levels(scene_, folder()));
  const Scene other = small_scene(2);
  EXPECT_FALSE(cached_levels(other, folder()).from_file);
  EXPECT_TRUE(cached_levels(scene_, folder()).from_file);
  EXPECT_NE(level_file(folder(), scene_.hash), level_file(folder(), other.hash));
}

TEST_F(LevelCache, ReplacesABrokenFile) {
  static_cast<void>(cached_levels(scene_, folder()));
  const std::filesystem::path file = level_file(folder(), scene_.hash);
  const std::vector<std::byte> whole = read_file(file, 1 << 24).value();
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{9}, std::size_t{60}, whole.size() / 2, whole.size() - 1}) {
    std::vector<std::byte> broken = whole;
    broken[at] ^= std::byte{0x40};
    ASSERT_TRUE(write_file_atomically(file, broken));
    const CachedLevels levels = cached_levels(scene_, folder());
    EXPECT_FALSE(levels.from_file) << at;
    EXPECT_NE(levels.trouble.find("replaced"), std::string::npos) << levels.trouble;
    EXPECT_TRUE(cached_levels(scene_, folder()).from_file) << "the file was replaced";
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{40}, whole.size() - 5}) {
    ASSERT_TRUE(write_file_atomically(file, std::span(whole).first(size)));
    EXPECT_FALSE(cached_levels(scene_, folder()).from_file) << size;
  }
}

// A file with a valid digest may still have been made by somebody else.
TEST_F(LevelCache, RefusesLevelsThatDoNotFitTheScene) {
  SceneLevels levels = make_levels(scene_);
  ASSERT_TRUE(decode_levels(scene_, encode_levels(scene_, levels)));
  const auto refused = [&](auto edit) {
    SceneLevels edited = levels;
    edit(edited[0]);
    return !decode_levels(scene_, encode_levels(scene_, edited));
  };
  EXPECT_TRUE(refused([](MeshLevels& mesh) { mesh.triangles[5].y = 1u << 30; })) << "vertex out of range";
  EXPECT_TRUE(refused([](MeshLevels& mesh) { mesh.levels[0].first = 1; }));
  EXPECT_TRUE(refused([](MeshLevels& mesh) { mesh.levels[1].count += 1; }));
  EXPECT_TRUE(refused([](MeshLevels& mesh) { mesh.levels[1].error = -1; }));
  EXPECT_TRUE(refused([](MeshLevels& mesh) { mesh.levels[0].error = std::nanf(""); }));
  EXPECT_TRUE(refused([](MeshLevels& mesh) { mesh.triangles.pop_back(); }));
  EXPECT_FALSE(decode_levels(small_scene(2), encode_levels(scene_, levels))) << "of another scene";
}

TEST_F(LevelCache, WorksWithoutAUsableFolder) {
  std::ofstream(folder()) << "a file where the folder should be";
  const CachedLevels levels = cached_levels(scene_, folder());
  EXPECT_FALSE(levels.from_file);
  EXPECT_NE(levels.trouble, "");
  EXPECT_TRUE(same(levels.levels, make_levels(scene_)));
}

TEST_F(LevelCache, TakesSeveralWritersAtOnce) {
  std::vector<std::thread> writers;
  std::vector<CachedLevels> results(4);
  for (CachedLevels& result : results)
    writers.emplace_back([&] { result = cached_levels(scene_, folder()); });
  for (std::thread& writer : writers) writer.join();
  for (const CachedLevels& result : results) EXPECT_TRUE(same(result.levels, make_levels(scene_)));
  EXPECT_TRUE(cached_levels(scene_, folder()).from_file);
}

}  // namespace
}  // namespace farshade
