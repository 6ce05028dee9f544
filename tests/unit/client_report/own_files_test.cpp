#include "vr_client/report/own_files.h"

#include <gtest/gtest.h>

#include <set>

#include "stereo/base/files.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

std::set<std::string> files_in(const fs::path& folder) {
  std::set<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    found.insert(entry.path().lexically_relative(folder).generic_string());
  return found;
}

TEST(RemoveOwnFiles, RemovesThoseOfARunAndNothingElse) {
  const ScratchFolder folder;
  fs::create_directories(folder.path() / "dump/frame_0010");
  fs::create_directories(folder.path() / "dump/frame_0020");
  fs::create_directories(folder.path() / "frame_0001_left.png");
  const std::vector<std::string> own{"summary.csv",
                                     "summary.json",
                                     "frames.csv",
                                     "worst.png",
                                     "worst_0012_left_difference_x8.png",
                                     "worst_12345_right_source.png",
                                     "frame_0012_right.png",
                                     "dump/frame_0010/views.json",
                                     "dump/frame_0010/left_lookup_x.pfm",
                                     "dump/frame_0020/right_mask_traced.png"};
  const std::vector<std::string> others{
      "notes.txt",    "summary.csv.bak",          "frame_12_left.png",
      "frames_0001",  "screenshot_0001_left.png", "capture_0001.farshade",
      "my_worst.png", "dump/frame_0020/notes",    "worst_0012_left_other.png"};
  for (const auto* list : {&own, &others})
    for (const std::string& name : *list)
      ASSERT_TRUE(write_file_atomically(folder.path() / name, "x")) << name;
  fs::create_symlink("notes.txt", folder.path() / "frame_0077_left.png");
  ASSERT_TRUE(remove_own_files(folder.path()).has_value());
  std::set<std::string> left(others.begin(), others.end());
  left.insert({"dump", "dump/frame_0020", "frame_0001_left.png", "frame_0077_left.png"});
  EXPECT_EQ(files_in(folder.path()), left);
  EXPECT_TRUE(remove_own_files(folder.path() / "none").has_value()) << "nothing to remove";
}

}  // namespace
}  // namespace farshade
