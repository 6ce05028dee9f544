#include "vr_client/fetch/scene_cache.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <barrier>
#include <cerrno>
#include <csignal>
#include <thread>

#include "stereo/base/files.h"
#include "tests/support/watched_fsync.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

const auto kWaits = [] { return true; };

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

/// Three files; the last one lies in a folder.
const std::vector<std::string> kContents{"the scene", "texture", "positions and normals"};
std::vector<OfferedFile> three_files() {
  std::vector<OfferedFile> files{{"a.gltf"}, {"b.png"}, {"sub/c.bin"}};
  for (std::size_t i = 0; i < files.size(); ++i) {
    files[i].bytes = kContents[i].size();
    files[i].hash = digest_of(bytes_of(kContents[i]));
  }
  return files;
}
const std::string kAll = kContents[0] + kContents[1] + kContents[2];

SceneCache open_three(const fs::path& folder) {
  auto cache = SceneCache::open(folder, three_files(), kWaits);
  if (!cache) throw std::runtime_error(cache.error().what);
  return *std::move(cache);
}

TEST(SceneCache, ALinkInPlaceOfItsFoldersIsRefused) {
  const ScratchFolder scratch;
  const fs::path own = open_three(scratch.path() / "first").scene().parent_path().filename();
  for (const char* suffix : {"", ".part"}) {
    const fs::path folder = scratch.path() / ("second" + std::string(suffix)),
                   elsewhere = scratch.path() / "elsewhere";
    fs::create_directories(folder);
    fs::create_directories(elsewhere);
    fs::create_directory_symlink(elsewhere, folder / (own.string() + suffix));
    const auto cache = SceneCache::open(folder, three_files(), kWaits);
    ASSERT_FALSE(cache) << suffix;
    EXPECT_NE(cache.error().what.find("is no folder: delete it"), std::string::npos) << cache.error().what;
    EXPECT_TRUE(fs::is_empty(elsewhere));
  }
}

/// One of them makes its folders, the others find them made in the middle of their own attempt. The lock lets
/// one in at a time.
TEST(SceneCache, ClientsThatOpenItAtOnceMakeItsFoldersTogether) {
  const ScratchFolder scratch;
  constexpr int kClients = 4, kRounds = 300;
  std::barrier begins(kClients);
  std::array<std::vector<std::string>, kClients> refusals;
  {
    std::vector<std::jthread> clients;
    for (std::vector<std::string>& refused : refusals)
      clients.emplace_back([&] {
        for (int round = 0; round < kRounds; ++round) {
          begins.arrive_and_wait();
          const auto cache =
              SceneCache::open(scratch.path() / std::to_string(round), three_files(), [] { return false; });
          if (!cache && cache.error().fault != Fault::Unavailable) refused.push_back(cache.error().what);
        }
      });
  }
  for (const std::vector<std::string>& refused : refusals)
    EXPECT_TRUE(refused.empty()) << refused.size() << " times: " << refused.front();
}

TEST(SceneCache, GoesOnWhereItWasCut) {
  const ScratchFolder scratch;
  for (std::size_t cut = 0; cut <= kAll.size(); ++cut) {
    SCOPED_TRACE(cut);
    const fs::path folder = scratch.path() / std::to_string(cut);
    {
      SceneCache cache = open_three(folder);
      EXPECT_EQ(cache.missing(), (ContentRange{0, kAll.size()}));
      ASSERT_TRUE(cache.append(bytes_of(kAll).first(cut)));
    }
    SceneCache cache = open_three(folder);
    EXPECT_EQ(cache.missing_bytes(), kAll.size() - cut);
    while (const auto range = cache.missing())
      ASSERT_TRUE(cache.append(bytes_of(kAll).subspan(range->begin, range->end - range->begin)));
    EXPECT_EQ(*read_file(cache.scene(), 100),
              std::vector(bytes_of(kContents[0]).begin(), bytes_of(kContents[0]).end()));
    EXPECT_EQ(read_file(cache.scene().parent_path() / "sub/c.bin", 100)->size(), kContents[2].size());
  }
}

TEST(SceneCache, FetchesOnlyTheFileThatIsBroken) {
  const ScratchFolder scratch;
  fs::path scene;
  {
    SceneCache cache = open_three(scratch.path());
    ASSERT_TRUE(cache.append(bytes_of(kAll)));
    scene = cache.scene();
  }
  ASSERT_TRUE(write_file_atomically(scene.parent_path() / "b.png", std::string_view("texturE")));
  SceneCache cache = open_three(scratch.path());
  EXPECT_EQ(cache.missing(), (ContentRange{9, 16}));
  ASSERT_TRUE(cache.append(bytes_of(kContents[1])));
  EXPECT_FALSE(cache.missing());
}

TEST(SceneCache, RefusesAWrongHash) {
  const ScratchFolder scratch;
  SceneCache cache = open_three(scratch.path());
  const Expected<void> done = cache.append(bytes_of("THE SCENE"));
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, Fault::Mismatch);
  EXPECT_FALSE(fs::exists(cache.scene()));
  EXPECT_EQ(cache.missing_bytes(), kAll.size());
}

TEST(SceneCache, FetchesAFileAgainWhoseFirstPartWasWrong) {
  const ScratchFolder scratch;
  { ASSERT_TRUE(open_three(scratch.path()).append(bytes_of("THE"))); }
  SceneCache cache = open_three(scratch.path());
  EXPECT_EQ(cache.missing(), (ContentRange{3, kAll.size()}));
  ASSERT_TRUE(cache.append(bytes_of(kAll).subspan(3)));
  EXPECT_EQ(cache.missing(), (ContentRange{0, kAll.size()})) << "what followed the wrong file was not used";
  ASSERT_TRUE(cache.append(bytes_of(kAll)));
  EXPECT_FALSE(cache.missing());
}

TEST(SceneCache, WritesThroughNoLink) {
  const ScratchFolder scratch;
  const fs::path victim = scratch.path() / "victim", folder = scratch.path() / "cache";
  fs::create_directories(victim);
  fs::path scene = open_three(folder).scene();
  fs::remove_all(scene.parent_path() / "sub");
  fs::create_directory_symlink(victim, scene.parent_path() / "sub");
  const auto opened = SceneCache::open(folder, three_files(), kWaits);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("delete it"), std::string::npos);
  fs::remove(scene.parent_path() / "sub");

  // A part that is a link is replaced, not followed.
  ASSERT_TRUE(write_file_atomically(victim / "file", std::string_view("kept")));
  fs::create_symlink(victim / "file", fs::path(scene.parent_path().string() + ".part") / "0");
  SceneCache cache = open_three(folder);
  ASSERT_TRUE(cache.append(bytes_of(kAll)));
  EXPECT_EQ(read_file(victim / "file", 100)->size(), 4u);
}

TEST(SceneCache, KeepsWhatFitsOnAFullDisk) {
  const ScratchFolder scratch;
  SceneCache cache = open_three(scratch.path());
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const Expected<void> done = cache.append(bytes_of(kAll));
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("full"), std::string::npos) << done.error().what;
  EXPECT_NE(done.error().what.find("XDG_CACHE_HOME"), std::string::npos);
  EXPECT_EQ(cache.missing(), (ContentRange{4, kAll.size()}));
  ASSERT_TRUE(cache.append(bytes_of(kAll).subspan(4))) << "after room was made";
  EXPECT_FALSE(cache.missing());
}

TEST(SceneCache, AFileIsOnTheDiskBeforeItIsRenamed) {
  const ScratchFolder scratch;
  SceneCache cache = open_three(fs::canonical(scratch.path()));
  const fs::path parts = cache.scene().parent_path().string() + ".part";
  const WatchedFsync watched;
  ASSERT_TRUE(cache.append(bytes_of(kAll)));
  EXPECT_EQ(watched.synced, (std::vector{parts / "0", parts / "1", parts / "2"}));
}

TEST(SceneCache, AFileThatDoesNotGetToTheDiskIsNotTaken) {
  const ScratchFolder scratch;
  SceneCache cache = open_three(scratch.path());
  WatchedFsync watched;
  watched.fails_with = EIO;
  const Expected<void> done = cache.append(bytes_of(kAll));
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, Fault::Unreadable);
  EXPECT_FALSE(fs::exists(cache.scene()));
}

TEST(SceneCache, RefusesASceneForWhichTheDiskHasNoRoom) {
  const ScratchFolder scratch;
  const auto disk = fs::space(scratch.path());
  const auto opened =
      SceneCache::open(scratch.path(), {{"a.glb", disk.available + (std::uint64_t{1} << 34), {}}}, kWaits);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("full"), std::string::npos);
}

TEST(SceneCache, IsLockedByOneAtATime) {
  const ScratchFolder scratch;
  std::optional<SceneCache> first = open_three(scratch.path());
  int requested = 0;
  const auto second = SceneCache::open(scratch.path(), three_files(), [&] { return ++requested < 3; });
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().fault, Fault::Unavailable);
  // One that waits goes on when the first is done, and finds everything there.
  std::jthread other([&] {
    const SceneCache cache = open_three(scratch.path());
    EXPECT_FALSE(cache.missing());
  });
  ASSERT_TRUE(first->append(bytes_of(kAll)));
  first.reset();
}

}  // namespace
}  // namespace farshade
