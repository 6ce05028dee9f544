#include "stereo/base/files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>

#include "stereo/base/file_watch.h"
#include "tests/support/watched_fsync.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  const auto bytes = read_file(path, 1000).value();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::ptrdiff_t entries_in(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

/// A file that changes between two looks is not complete yet.
TEST(FileWatch, TellsOnceThatAFileHasChangedWhenItHasSettled) {
  const ScratchFolder folder;
  const fs::path path = folder.path() / "a";
  ASSERT_TRUE(write_file_atomically(path, "text"));
  const fs::file_time_type first = fs::last_write_time(path);
  const auto change = [&](int seconds) { fs::last_write_time(path, first + std::chrono::seconds(seconds)); };
  FileWatch watch(path);
  EXPECT_FALSE(watch.has_changed());
  change(1);
  EXPECT_FALSE(watch.has_changed()) << "the first look";
  EXPECT_TRUE(watch.has_changed());
  EXPECT_FALSE(watch.has_changed()) << "once";
  change(2);
  EXPECT_FALSE(watch.has_changed());
  change(3);
  EXPECT_FALSE(watch.has_changed()) << "it has changed further";
  EXPECT_TRUE(watch.has_changed());
  change(4);
  watch.mark_as_seen();
  EXPECT_FALSE(watch.has_changed());
  EXPECT_FALSE(watch.has_changed());
}

TEST(WriteFile, ReplacesWhatWasThere) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file_atomically(folder.path() / "a", "a longer first text"));
  ASSERT_TRUE(write_file_atomically(folder.path() / "a", "second"));
  EXPECT_EQ(text_of(folder.path() / "a"), "second");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(WriteFile, LeavesNothingBehindOnFailure) {
  const ScratchFolder folder;
  fs::create_directory(folder.path() / "taken");  // a file cannot be renamed over a folder
  const auto written = write_file_atomically(folder.path() / "taken", "text");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().fault, Fault::Unreadable);
  EXPECT_NE(written.error().what.find((folder.path() / "taken").string()), std::string::npos);
  EXPECT_NE(written.error().what.find("Is a directory"), std::string::npos) << written.error().what;
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(IsPrivate, AFileOfOneUserOrOneThatRootGivesToAGroup) {
  constexpr unsigned kRoot = 0, kMe = 1000, kOther = 1001;
  for (const unsigned mode : {0600u, 0400u, 0700u, 0711u}) EXPECT_TRUE(is_private(mode, kMe, kMe)) << mode;
  for (const unsigned mode : {0640u, 0440u}) {
    EXPECT_TRUE(is_private(mode, kRoot, kMe)) << mode;
    EXPECT_FALSE(is_private(mode, kRoot, kRoot)) << mode << ": root can make it private";
    EXPECT_FALSE(is_private(mode, kMe, kMe)) << mode;
    EXPECT_FALSE(is_private(mode, kOther, kMe)) << mode;
  }
  for (const unsigned mode : {0644u, 0604u, 0660u, 0620u, 0642u, 0602u, 0666u})
    for (const unsigned owner : {kRoot, kMe}) EXPECT_FALSE(is_private(mode, owner, kMe)) << mode;
}

TEST(WriteFile, APrivateOneIsOnTheDiskBeforeItIsRenamed) {
  const ScratchFolder folder;
  const fs::path home = fs::canonical(folder.path());
  for (const IfThere if_there : {IfThere::Refuse, IfThere::Replace}) {
    const WatchedFsync watched;
    ASSERT_TRUE(write_private_file(home / "a", "text", if_there));
    EXPECT_EQ(watched.synced, (std::vector{home / ("a.partial-" + std::to_string(::gettid())), home}));
  }
  const WatchedFsync watched;
  ASSERT_TRUE(write_file_atomically(home / "b", "text"));
  EXPECT_TRUE(watched.synced.empty()) << "others need not outlive a power cut";
}

TEST(WriteFile, APrivateOneThatDoesNotGetToTheDiskIsNotThere) {
  const ScratchFolder folder;
  WatchedFsync watched;
  watched.fails_with = EIO;
  const auto written = write_private_file(folder.path() / "a", "text", IfThere::Replace);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().fault, Fault::Unreadable);
  EXPECT_EQ(entries_in(folder.path()), 0);
}

TEST(WriteFile, NamesMissingFolder) {
  const ScratchFolder folder;
  const auto written = write_file_atomically(folder.path() / "none" / "a", "text");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().fault, Fault::Missing);
  EXPECT_EQ(entries_in(folder.path()), 0);
}

TEST(WriteFile, FollowsNoLinkThatWaitsAtItsPartialName) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file_atomically(folder.path() / "a", "old"));
  ASSERT_TRUE(write_file_atomically(folder.path() / "elsewhere", "untouched"));
  fs::create_symlink("elsewhere", folder.path() / ("a.partial-" + std::to_string(::gettid())));
  EXPECT_FALSE(write_file_atomically(folder.path() / "a", "new"));
  EXPECT_EQ(text_of(folder.path() / "a"), "old");
  EXPECT_EQ(text_of(folder.path() / "elsewhere"), "untouched");
}

/// Limits files to eight bytes from now on. Call it in a process of its own.
[[noreturn]] void overwrite_with_no_space_left(const fs::path& path) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit eight_bytes{8, 8};
  ::setrlimit(RLIMIT_FSIZE, &eight_bytes);
  std::_Exit(write_file_atomically(path, "more than eight bytes") ? 1 : 0);
}

TEST(WriteFileDeathTest, KeepsOldFileWhenSpaceRunsOut) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file_atomically(folder.path() / "a", "old"));
  EXPECT_EXIT(overwrite_with_no_space_left(folder.path() / "a"), testing::ExitedWithCode(0), "");
  EXPECT_EQ(text_of(folder.path() / "a"), "old");
  EXPECT_EQ(entries_in(folder.path()), 1);
}

TEST(ReadFile, RefusesMoreThanAllowed) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file_atomically(folder.path() / "a", "12345"));
  EXPECT_TRUE(read_file(folder.path() / "a", 5));
  EXPECT_EQ(read_file(folder.path() / "a", 4).error().fault, Fault::OutOfRange);
}

TEST(ReadFile, RefusesWhatIsNoRegularFile) {
  const ScratchFolder folder;
  EXPECT_EQ(read_file(folder.path() / "none", 10).error().fault, Fault::Missing);
  EXPECT_EQ(read_file(folder.path(), 10).error().fault, Fault::Unreadable);
  const fs::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(read_file(pipe, 10).error().fault, Fault::Unreadable);  // and it does not wait for a writer
}

TEST(ReadFile, ReadsEmptyFile) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file_atomically(folder.path() / "a", ""));
  EXPECT_EQ(text_of(folder.path() / "a"), "");
}

TEST(Files, MakingAFolderLeavesWhatIsThere) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file_atomically(folder.path() / ".probe", std::string_view("mine")));
  ASSERT_TRUE(make_folder(folder.path()));
  EXPECT_EQ(read_file(folder.path() / ".probe", 10).value().size(), 4u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()),
                          std::filesystem::directory_iterator()),
            1)
      << "and nothing new";
}

}  // namespace
}  // namespace farshade
